// SPDX-License-Identifier: MIT
// Encoded meshes <-> streams of bounded chunks with offsets and a checksum at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"
#include "limn/v1/mesh.pb.h"

namespace limn::wire {

// Largest data of a chunk, in bytes.
inline constexpr std::size_t kMaxChunkBytes = std::size_t{1} << 20;

// XXH3, 64 bit, seed 0. Thread-safe.
[[nodiscard]] std::uint64_t Checksum(std::string_view bytes);

// Cuts bytes into chunks. The bytes must outlive it. An empty string gives no chunk.
class ChunkReader {
 public:
  // chunk_bytes: 1 to kMaxChunkBytes; values outside are taken as the nearer end.
  explicit ChunkReader(std::string_view bytes, std::size_t chunk_bytes = std::size_t{512} << 10);
  // Fills the next chunk; false when there is none left.
  bool Next(v1::MeshChunk* chunk);

 private:
  std::string_view bytes_;
  std::size_t chunk_bytes_;
  std::size_t offset_ = 0;
};

// Puts chunks together again. Memory grows with what has arrived, not with what was claimed.
class ChunkAssembler {
 public:
  // expected_bytes: the header's byte_count, already held against the limits.
  explicit ChunkAssembler(std::uint64_t expected_bytes);

  // Takes the next chunk. Errors: MALFORMED_REQUEST for a gap, an overlap, an empty or too large
  // chunk, more bytes than announced, a last chunk too early, a chunk after the last, all bytes
  // without a last chunk; CHECKSUM_MISMATCH; OUT_OF_MEMORY. After an error nothing more is taken.
  [[nodiscard]] absl::Status Add(const v1::MeshChunk& chunk);

  // Whether the last chunk has come.
  bool complete() const { return complete_; }
  const std::string& bytes() const { return bytes_; }
  std::string TakeBytes() { return std::move(bytes_); }

 private:
  std::uint64_t expected_bytes_;
  std::string bytes_;
  bool complete_ = false;
};

}  // namespace limn::wire
