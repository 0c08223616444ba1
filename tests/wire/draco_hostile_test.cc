// SPDX-License-Identifier: MIT
// Draco bytes that are cut, flipped, made up or lie about their size: refused, or decoded to a mesh
// that is sound; quickly, and without much memory. Run it under the address sanitizer too.
#include <array>
#include <chrono>
#include <functional>
#include <iostream>
#include <random>

#include "proto/wire/draco_header.h"
#include "proto/wire/mesh_codec.h"
#include "tests/engine/allocation_meter.h"
#include "tests/oracle/slowdown.h"
#include "tests/wire/foreign_draco.h"
#include "tests/wire/test_meshes.h"

namespace limn::wire {
namespace {

constexpr std::uint32_t kSeed = 977;
constexpr v1::MeshEncoding kDraco[] = {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED};

absl::StatusOr<PolygonMesh> Decode(const std::string& bytes) {
  v1::MeshHeader header;
  header.set_encoding(v1::MESH_ENCODING_DRACO);
  header.set_byte_count(bytes.size());
  return DecodeMesh(Context(), header, bytes);
}

void ExpectSoundOrRefused(const std::string& bytes) {
  const auto mesh = Decode(bytes);
  if (!mesh.ok()) {
    const Reason reason = GetErrorDetail(mesh.status())->reason;
    EXPECT_TRUE(reason == Reason::kMalformedEncoding || reason == Reason::kLimitExceeded ||
                reason == Reason::kMalformedRequest)
        << mesh.status();
    return;
  }
  ASSERT_EQ(mesh->face_begin.front(), 0U);
  ASSERT_EQ(mesh->face_begin.back(), mesh->corner_count());
  for (std::size_t f = 0; f < mesh->face_count(); ++f) ASSERT_GE(mesh->arity(f), 3U);
  for (const Index v : mesh->corner_vertex) ASSERT_LT(v, mesh->vertex_count());
}

std::vector<std::string> Samples() {
  std::vector<std::string> samples;
  for (const v1::MeshEncoding encoding : kDraco) {
    for (const PolygonMesh& mesh :
         {Tetrahedron(), Cube(), Prism(7), Torus(5, 5), IrregularTorus(5, 4, kSeed)}) {
      samples.push_back(EncodeMesh(Context(), mesh, {.encoding = encoding})->bytes);
    }
  }
  return samples;
}

void ExpectCheap(const std::function<void()>& work,
                 std::chrono::milliseconds limit = std::chrono::milliseconds(50) *
                                                   oracle::kSlowdown) {
  // Not the process's resident pages: sanitizers keep freed memory for a while.
  const AllocationMeter meter;
  const auto start = std::chrono::steady_clock::now();
  work();
  EXPECT_LT(std::chrono::steady_clock::now() - start, limit);
  EXPECT_LT(meter.peak(), std::size_t{64} << 20);
}

std::string Varint(std::uint32_t value) {
  std::string out;
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<char>(value | 0x80));
  out.push_back(static_cast<char>(value));
  return out;
}

std::string Prefix(int method, bool metadata = false) {
  return std::string("DRACO\x02\x02\x01", 8) + static_cast<char>(method) + '\0' +
         (metadata ? '\x80' : '\0');
}

// traversal, vertices, triangles, attributes, symbols, splits.
std::string Edgebreaker(int traversal, std::array<std::uint32_t, 5> claims) {
  return Prefix(1) + static_cast<char>(traversal) + Varint(claims[0]) + Varint(claims[1]) +
         static_cast<char>(claims[2]) + Varint(claims[3]) + Varint(claims[4]);
}

std::string PadTo(std::string bytes, std::size_t size) {
  bytes.resize(size, '\0');
  return bytes;
}

TEST(DracoHostileTest, EveryTruncationIsRefused) {
  for (const std::string& sample : Samples()) {
    ASSERT_TRUE(Decode(sample).ok());
    for (std::size_t size = 1; size < sample.size(); ++size) {
      ExpectSoundOrRefused(sample.substr(0, size));
    }
    EXPECT_FALSE(Decode(sample.substr(0, sample.size() / 2)).ok());
  }
}

TEST(DracoHostileTest, EveryFlippedBitIsRefusedOrHarmless) {
  for (const std::string& sample : Samples()) {
    for (std::size_t i = 0; i < sample.size(); ++i) {
      for (int bit = 0; bit < 8; ++bit) {
        std::string bytes = sample;
        bytes[i] = static_cast<char>(bytes[i] ^ 1 << bit);
        ExpectSoundOrRefused(bytes);
      }
    }
  }
}

TEST(DracoHostileTest, RandomDamageIsRefusedOrHarmless) {
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  const std::vector<std::string> samples = Samples();
  for (int round = 0; round < 20000; ++round) {
    std::string bytes = samples[random() % samples.size()];
    for (unsigned hits = 1 + random() % 8; hits > 0; --hits) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    ExpectSoundOrRefused(bytes);
  }
}

TEST(DracoHostileTest, GarbageIsRefused) {
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  for (int round = 0; round < 5000; ++round) {
    std::string bytes = round % 3 == 0 ? "" : Prefix(round % 3 - 1, round % 2 == 0);
    for (unsigned n = 1 + random() % 300; n > 0; --n) bytes.push_back(static_cast<char>(random()));
    ExpectSoundOrRefused(bytes);
  }
}

TEST(DracoHostileTest, ClaimsThatTheBytesDoNotJustifyAreRefusedCheaply) {
  const std::uint32_t many = 100'000'000;
  for (const int traversal : {0, 2}) {
    ExpectCheap([&] {
      ExpectError(
          Decode(PadTo(Edgebreaker(traversal, {many / 2, many, 1, many - 1, 0}), 66)).status(),
          Reason::kMalformedEncoding);
      ExpectError(Decode(PadTo(Edgebreaker(traversal, {3, many, 0, many, many}), 66)).status(),
                  Reason::kMalformedEncoding);
    });
  }
  ExpectCheap([&] {
    ExpectError(Decode(PadTo(Prefix(0) + Varint(many) + Varint(many), 66)).status(),
                Reason::kMalformedEncoding);
    ExpectError(Decode(PadTo(Prefix(0) + Varint(10) + Varint(many), 66)).status(),
                Reason::kMalformedEncoding);
  });
}

// Claims that the number of bytes could justify must still not cost more than the limits allow.
TEST(DracoHostileTest, ClaimsAboveTheLimitsAreRefusedCheaply) {
  const std::string bytes = PadTo(Edgebreaker(0, {2'000'000, 4'000'000, 7, 3'999'999, 0}), 600'000);
  v1::MeshHeader header;
  header.set_encoding(v1::MESH_ENCODING_DRACO);
  header.set_byte_count(bytes.size());
  ExpectCheap([&] {
    ExpectError(DecodeMesh(Context(Limits{.max_corners = 3'000'000}), header, bytes).status(),
                Reason::kLimitExceeded);
    ExpectError(DecodeMesh(Context(Limits{.max_bytes = 100 << 20}), header, bytes).status(),
                Reason::kLimitExceeded);
    header.set_face_count(1000);
    header.set_corner_count(3000);
    ExpectError(DecodeMesh(Context(), header, bytes).status(), Reason::kMalformedEncoding);
  });
}

// Draco's predictor of texture coordinates would loop as often as four of these bytes say.
TEST(DracoHostileTest, NoCountInsideTheBytesIsBelieved) {
  std::vector<std::string> samples = Samples();
  const auto foreign = ForeignMesh<float>(TriangleTorus(), draco::DT_FLOAT32);
  AddForeignAttributes(foreign.get());
  for (const int speed : {0, 3, 5, 7}) {
    samples.push_back(ForeignBytes(*foreign, draco::MESH_EDGEBREAKER_ENCODING, speed));
  }
  ExpectCheap(
      [&] {
        for (const std::string& sample : samples) {
          for (std::size_t i = 0; i + 4 <= sample.size(); ++i) {
            std::string bytes = sample;
            bytes.replace(i, 4, "\xff\xff\xff\x7f");
            ExpectSoundOrRefused(bytes);
          }
        }
      },
      std::chrono::seconds(60));
}

TEST(DracoHostileTest, HeaderErrorsSayWhatIsWrong) {
  const auto message = [](const std::string& bytes) {
    const auto header = ReadDracoHeader(bytes);
    EXPECT_FALSE(header.ok());
    return std::string(header.status().message());
  };
  using testing::HasSubstr;
  EXPECT_THAT(message(""), HasSubstr("does not begin"));
  EXPECT_THAT(message("# OBJ file, not Draco"), HasSubstr("does not begin"));
  EXPECT_THAT(message("DRACO\x02\x02\x01"), HasSubstr("does not begin"));
  EXPECT_THAT(message(std::string("DRACO\x02\x01\x01\x01\0\0", 11)), HasSubstr("2.1"));
  EXPECT_THAT(message(std::string("DRACO\x02\x02\0\0\0\0", 11)), HasSubstr("point cloud"));
  EXPECT_THAT(message(std::string("DRACO\x02\x02\x01\x02\0\0", 11)), HasSubstr("sequential"));
  EXPECT_THAT(message(Prefix(0)), HasSubstr("ends in its header"));
  EXPECT_THAT(message(Prefix(1) + '\0'), HasSubstr("ends in its header"));
  EXPECT_THAT(message(Prefix(0) + "\xff\xff\xff\xff\xff\xff"), HasSubstr("ends in its header"));
  EXPECT_THAT(message(PadTo(Prefix(0) + Varint(0), 30)), HasSubstr("no triangles"));
  EXPECT_THAT(message(PadTo(Edgebreaker(1, {4, 4, 0, 4, 0}), 66)), HasSubstr("traversal 1"));
  EXPECT_THAT(message(PadTo(Edgebreaker(0, {4, 9, 0, 4, 0}), 66)), HasSubstr("fit together"));
  EXPECT_THAT(message(PadTo(Edgebreaker(0, {4, 4, 0, 4, 5}), 66)), HasSubstr("fit together"));
  EXPECT_THAT(message(PadTo(Edgebreaker(0, {13, 4, 0, 4, 0}), 66)), HasSubstr("fit together"));
  EXPECT_THAT(message(PadTo(Edgebreaker(0, {4, 4, 8, 4, 0}), 66)), HasSubstr("attributes"));
}

TEST(DracoHostileTest, MetadataAreBounded) {
  const auto refused = [](const std::string& metadata) {
    ExpectError(ReadDracoHeader(Prefix(0, true) + metadata + std::string(100, '\0')).status(),
                Reason::kMalformedEncoding);
  };
  refused(Varint(~0U));
  refused(Varint(0) + Varint(~0U));
  // An entry of 4 GiB; one of no bytes.
  refused(Varint(0) + Varint(1) +
          "\x01"
          "n" +
          Varint(~0U));
  refused(Varint(0) + Varint(1) +
          "\x01"
          "n" +
          Varint(0));
  // Nesting.
  std::string deep = Varint(0);
  for (int i = 0; i < 500; ++i) deep += Varint(0) + Varint(1) + '\0';
  refused(deep);
  // Many small entries.
  std::string many = Varint(0) + Varint(2000);
  for (int i = 0; i < 2000; ++i) many += std::string("\0\x01x", 3);
  refused(many);
}

}  // namespace
}  // namespace limn::wire
