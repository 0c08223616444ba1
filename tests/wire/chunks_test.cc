// SPDX-License-Identifier: MIT
// Chunks: what is cut up comes together again, and every way of getting it wrong is refused.
#include "proto/wire/chunks.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/wire/test_meshes.h"

namespace limn::wire {
namespace {

std::string Bytes(std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 31 + i / 256);
  return bytes;
}

std::vector<v1::MeshChunk> Cut(const std::string& bytes, std::size_t chunk_bytes) {
  std::vector<v1::MeshChunk> chunks;
  ChunkReader reader(bytes, chunk_bytes);
  for (v1::MeshChunk chunk; reader.Next(&chunk);) chunks.push_back(chunk);
  return chunks;
}

TEST(ChunksTest, ChecksumIsXxh3OfSeedZero) {
  EXPECT_EQ(Checksum(""), 0x2d06800538d394c2U);
  EXPECT_NE(Checksum("a"), Checksum("b"));
}

TEST(ChunksTest, WhatIsCutUpComesTogetherAgain) {
  for (const std::size_t size : {1, 99, 100, 101, 1000}) {
    const std::string bytes = Bytes(size);
    ChunkAssembler assembler(size);
    for (const v1::MeshChunk& chunk : Cut(bytes, 100)) {
      EXPECT_FALSE(assembler.complete());
      ASSERT_TRUE(assembler.Add(chunk).ok());
    }
    EXPECT_TRUE(assembler.complete());
    EXPECT_EQ(assembler.bytes(), bytes);
    EXPECT_EQ(assembler.TakeBytes(), bytes);
  }
}

TEST(ChunksTest, ChunksHaveOffsetsAndOnlyTheLastOneTheChecksum) {
  const std::string bytes = Bytes(250);
  const auto chunks = Cut(bytes, 100);
  ASSERT_EQ(chunks.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(chunks[i].offset(), 100 * i);
    EXPECT_EQ(chunks[i].data().size(), i < 2 ? 100U : 50U);
    EXPECT_EQ(chunks[i].last(), i == 2);
    EXPECT_EQ(chunks[i].xxh3(), i == 2 ? Checksum(bytes) : 0);
  }
}

TEST(ChunksTest, ChunkSizesStayWithinTheLimit) {
  EXPECT_TRUE(Cut("", 10).empty());
  EXPECT_EQ(Cut("abc", 0).size(), 3U);
  EXPECT_EQ(Cut(Bytes(kMaxChunkBytes + 1), 2 * kMaxChunkBytes).size(), 2U);
}

class BrokenChunksTest : public testing::Test {
 protected:
  // Breaks the chunks of 250 bytes; the first chunk from `at` on that is refused must say so.
  void ExpectRefused(Reason reason, std::string_view field,
                     const std::function<void(std::vector<v1::MeshChunk>*)>& break_them,
                     std::uint64_t expected_bytes = 250) {
    auto chunks = Cut(Bytes(250), 100);
    break_them(&chunks);
    ChunkAssembler assembler(expected_bytes);
    absl::Status status;
    for (const v1::MeshChunk& chunk : chunks) status.Update(assembler.Add(chunk));
    ExpectError(status, reason, field);
  }
};

TEST_F(BrokenChunksTest, GapsOverlapsAndDisorder) {
  const auto expect = [&](auto break_them) {
    ExpectRefused(Reason::kMalformedRequest, "chunk.offset", break_them);
  };
  expect([](auto* chunks) { chunks->erase(chunks->begin() + 1); });
  expect([](auto* chunks) { chunks->insert(chunks->begin(), chunks->front()); });
  expect([](auto* chunks) { std::swap((*chunks)[0], (*chunks)[1]); });
  expect([](auto* chunks) { (*chunks)[1].set_offset(~0ULL); });
}

TEST_F(BrokenChunksTest, SizesOfChunks) {
  const auto expect = [&](auto break_them, std::uint64_t expected_bytes) {
    ExpectRefused(Reason::kMalformedRequest, "chunk.data", break_them, expected_bytes);
  };
  expect([](auto* chunks) { (*chunks)[1].clear_data(); }, 250);
  expect([](auto* chunks) { (*chunks)[1].set_data(Bytes(kMaxChunkBytes + 1)); }, 1 << 30);
  expect([](auto* /*chunks*/) {}, 249);
}

TEST_F(BrokenChunksTest, LastChunk) {
  const auto expect = [&](auto break_them, std::uint64_t expected_bytes) {
    ExpectRefused(Reason::kMalformedRequest, "chunk.last", break_them, expected_bytes);
  };
  expect([](auto* chunks) { (*chunks)[1].set_last(true); }, 250);
  expect([](auto* /*chunks*/) {}, 251);
  expect([](auto* chunks) { (*chunks)[2].set_last(false); }, 250);
  expect([](auto* chunks) { chunks->push_back((*chunks)[2]); }, 250);
}

TEST_F(BrokenChunksTest, Checksum) {
  ExpectRefused(Reason::kChecksumMismatch, "chunk.xxh3",
                [](auto* chunks) { (*chunks)[1].mutable_data()->at(7) ^= 1; });
  ExpectRefused(Reason::kChecksumMismatch, "chunk.xxh3",
                [](auto* chunks) { (*chunks)[2].set_xxh3(1); });
}

}  // namespace
}  // namespace limn::wire
