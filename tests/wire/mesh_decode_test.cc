// SPDX-License-Identifier: MIT
// What decoding takes from other programs, and what it refuses: header claims and their limits,
// counts that do not fit, broken indices.
#include <array>
#include <cstring>

#include "proto/wire/mesh_codec.h"
#include "tests/wire/foreign_draco.h"
#include "tests/wire/test_meshes.h"

namespace limn::wire {
namespace {

v1::MeshHeader Header(v1::MeshEncoding encoding, std::array<std::uint64_t, 4> counts) {
  v1::MeshHeader header;
  header.set_encoding(encoding);
  header.set_vertex_count(counts[0]);
  header.set_face_count(counts[1]);
  header.set_corner_count(counts[2]);
  header.set_byte_count(counts[3]);
  return header;
}

absl::StatusOr<PolygonMesh> DecodeUnclaimed(const std::string& bytes, const Limits& limits = {}) {
  return DecodeMesh(Context(limits), Header(v1::MESH_ENCODING_DRACO, {0, 0, 0, bytes.size()}),
                    bytes);
}

EncodedMesh Encode(const PolygonMesh& mesh, v1::MeshEncoding encoding) {
  return *EncodeMesh(Context(), mesh, {.encoding = encoding});
}

// Faces as points, for meshes whose vertex order is lost.
std::vector<std::array<std::array<double, 3>, 3>> Soup(const PolygonMesh& mesh) {
  std::vector<std::array<std::array<double, 3>, 3>> soup;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    std::array<std::array<double, 3>, 3> face;
    for (int i = 0; i < 3; ++i) {
      const Vec3 p = mesh.positions[mesh.face(f)[i]];
      face[i] = {p.x, p.y, p.z};
    }
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    soup.push_back(face);
  }
  std::sort(soup.begin(), soup.end());
  return soup;
}

template <class T>
void ExpectForeignTypeDecodes(draco::DataType type) {
  const PolygonMesh mesh = TriangleTorus();
  const auto foreign = ForeignMesh<T>(mesh, type);
  const auto sequential =
      DecodeUnclaimed(ForeignBytes(*foreign, draco::MESH_SEQUENTIAL_ENCODING, 5));
  ASSERT_TRUE(sequential.ok()) << sequential.status();
  EXPECT_EQ(*sequential, mesh);
  const auto edgebreaker =
      DecodeUnclaimed(ForeignBytes(*foreign, draco::MESH_EDGEBREAKER_ENCODING, 5));
  ASSERT_TRUE(edgebreaker.ok()) << edgebreaker.status();
  EXPECT_EQ(Soup(*edgebreaker), Soup(mesh));
}

TEST(MeshDecodeTest, TakesForeignPositionsOfAnyNumericType) {
  ExpectForeignTypeDecodes<std::uint8_t>(draco::DT_UINT8);
  ExpectForeignTypeDecodes<std::int8_t>(draco::DT_INT8);
  ExpectForeignTypeDecodes<std::uint16_t>(draco::DT_UINT16);
  ExpectForeignTypeDecodes<std::int16_t>(draco::DT_INT16);
  ExpectForeignTypeDecodes<std::uint32_t>(draco::DT_UINT32);
  ExpectForeignTypeDecodes<std::int32_t>(draco::DT_INT32);
  ExpectForeignTypeDecodes<double>(draco::DT_FLOAT64);
}

TEST(MeshDecodeTest, TakesForeignMeshesOfEverySpeedWithOtherAttributes) {
  const PolygonMesh mesh = TriangleTorus();
  const auto foreign = ForeignMesh<float>(mesh, draco::DT_FLOAT32);
  AddForeignAttributes(foreign.get());
  for (int speed = 0; speed <= 10; ++speed) {
    const auto sequential =
        DecodeUnclaimed(ForeignBytes(*foreign, draco::MESH_SEQUENTIAL_ENCODING, speed));
    ASSERT_TRUE(sequential.ok()) << "speed " << speed << ": " << sequential.status();
    EXPECT_EQ(sequential->corner_vertex, mesh.corner_vertex);
    EXPECT_LE(MaxDeviation(sequential->positions, mesh.positions), 100.0 / 16383);
    const auto edgebreaker =
        DecodeUnclaimed(ForeignBytes(*foreign, draco::MESH_EDGEBREAKER_ENCODING, speed));
    if (speed >= 6) {
      // All attributes in one decoder, whose predictions cannot be looked at beforehand.
      ExpectError(edgebreaker.status(), Reason::kMalformedEncoding);
      continue;
    }
    ASSERT_TRUE(edgebreaker.ok()) << "speed " << speed << ": " << edgebreaker.status();
    EXPECT_EQ(edgebreaker->vertex_count(), mesh.vertex_count());
    EXPECT_EQ(edgebreaker->face_count(), mesh.face_count());
  }
  const auto plain = ForeignMesh<float>(mesh, draco::DT_FLOAT32);
  for (int speed = 0; speed <= 10; ++speed) {
    const auto edgebreaker =
        DecodeUnclaimed(ForeignBytes(*plain, draco::MESH_EDGEBREAKER_ENCODING, speed));
    ASSERT_TRUE(edgebreaker.ok()) << "speed " << speed << ": " << edgebreaker.status();
    EXPECT_EQ(edgebreaker->vertex_count(), mesh.vertex_count());
    EXPECT_EQ(edgebreaker->face_count(), mesh.face_count());
  }
  const auto compressed = DecodeUnclaimed(
      ForeignBytes(*foreign, draco::MESH_SEQUENTIAL_ENCODING, 5, /*compress_connectivity=*/true));
  ASSERT_TRUE(compressed.ok()) << compressed.status();
  EXPECT_EQ(compressed->corner_vertex, mesh.corner_vertex);
}

TEST(MeshDecodeTest, RefusesMeshesWithoutUsablePositions) {
  const auto bools = ForeignMesh<bool>(TriangleTorus(), draco::DT_BOOL);
  ExpectError(DecodeUnclaimed(ForeignBytes(*bools, draco::MESH_SEQUENTIAL_ENCODING, 5)).status(),
              Reason::kMalformedEncoding);
  const auto normals = ForeignMesh<double>(TriangleTorus(), draco::DT_FLOAT64);
  normals->attribute(0)->set_attribute_type(draco::GeometryAttribute::GENERIC);
  ExpectError(DecodeUnclaimed(ForeignBytes(*normals, draco::MESH_SEQUENTIAL_ENCODING, 5)).status(),
              Reason::kMalformedEncoding);
}

TEST(MeshDecodeTest, RefusesTooManyAttributesAndComponents) {
  for (const auto& [attributes, components] : {std::pair{8, 1}, std::pair{1, 5}}) {
    const auto foreign = ForeignMesh<double>(TriangleTorus(), draco::DT_FLOAT64);
    for (int i = 0; i < attributes; ++i) {
      draco::GeometryAttribute extra;
      extra.Init(draco::GeometryAttribute::GENERIC, nullptr, static_cast<std::uint8_t>(components),
                 draco::DT_UINT8, false, components, 0);
      foreign->AddAttribute(extra, true, foreign->num_points());
    }
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
      ExpectError(DecodeUnclaimed(ForeignBytes(*foreign, method, 5)).status(),
                  Reason::kMalformedEncoding);
    }
  }
}

TEST(MeshDecodeTest, CountsThatAreNotClaimedAreTakenFromDraco) {
  const PolygonMesh mesh = Prism(9);
  for (const v1::MeshEncoding encoding :
       {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    EncodedMesh encoded = Encode(mesh, encoding);
    encoded.header.set_vertex_count(0);
    encoded.header.set_face_count(0);
    encoded.header.set_corner_count(0);
    const auto back = DecodeMesh(Context(), encoded.header, encoded.bytes);
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(FaceSet(*back), FaceSet(mesh));
  }
}

TEST(MeshDecodeTest, CountsThatAreClaimedMustBeThoseOfTheBytes) {
  for (const v1::MeshEncoding encoding :
       {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    const EncodedMesh encoded = Encode(Prism(9), encoding);
    for (const int delta : {-1, 1}) {
      v1::MeshHeader header = encoded.header;
      header.set_vertex_count(header.vertex_count() + delta);
      ExpectError(DecodeMesh(Context(), header, encoded.bytes).status(), Reason::kMalformedEncoding,
                  "mesh.vertex_count");
      header = encoded.header;
      header.set_face_count(header.face_count() + delta);
      ExpectError(DecodeMesh(Context(), header, encoded.bytes).status(),
                  Reason::kMalformedEncoding);
      header = encoded.header;
      header.set_corner_count(header.corner_count() + delta);
      ExpectError(DecodeMesh(Context(), header, encoded.bytes).status(),
                  Reason::kMalformedEncoding);
      header = encoded.header;
      header.set_byte_count(header.byte_count() + delta);
      ExpectError(DecodeMesh(Context(), header, encoded.bytes).status(), Reason::kMalformedEncoding,
                  "mesh.byte_count");
    }
  }
}

TEST(MeshDecodeTest, UnclaimedCountsAreHeldAgainstTheLimits) {
  const PolygonMesh mesh = Prism(20);
  for (const v1::MeshEncoding encoding :
       {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    const std::string bytes = Encode(mesh, encoding).bytes;
    EXPECT_TRUE(
        DecodeUnclaimed(bytes, {.max_vertices = 40, .max_corners = mesh.corner_count()}).ok());
    ExpectError(DecodeUnclaimed(bytes, {.max_vertices = 39}).status(), Reason::kLimitExceeded);
    ExpectError(DecodeUnclaimed(bytes, {.max_corners = mesh.corner_count() - 1}).status(),
                Reason::kLimitExceeded);
    ExpectError(DecodeUnclaimed(bytes, {.max_corners = 75}).status(), Reason::kLimitExceeded);
    ExpectError(DecodeUnclaimed(bytes, {.max_bytes = 5000}).status(), Reason::kLimitExceeded);
  }
}

TEST(MeshDecodeTest, PackedCountsMustFitTheBytesAndEachOther) {
  const EncodedMesh encoded = Encode(Prism(9), v1::MESH_ENCODING_PACKED);
  v1::MeshHeader header = encoded.header;
  ExpectError(DecodeMesh(Context(), header, encoded.bytes.substr(1)).status(),
              Reason::kMalformedEncoding, "mesh.byte_count");
  ExpectError(DecodeMesh(Context(), header, encoded.bytes + "x").status(),
              Reason::kMalformedEncoding, "mesh.byte_count");
  // One face more and one corner less: the same size, other arities.
  header.set_face_count(header.face_count() + 1);
  header.set_corner_count(header.corner_count() - 1);
  ExpectError(DecodeMesh(Context(), header, encoded.bytes).status(), Reason::kMalformedEncoding,
              "mesh.corner_count");
}

TEST(MeshDecodeTest, PackedFacesMustBeSound) {
  const PolygonMesh prism = Prism(9);
  const EncodedMesh encoded = Encode(prism, v1::MESH_ENCODING_PACKED);
  const auto with = [&](std::size_t number, std::uint32_t value) {
    std::string bytes = encoded.bytes;
    std::memcpy(bytes.data() + 24 * prism.vertex_count() + 4 * number, &value, 4);
    return bytes;
  };
  const absl::Status index =
      DecodeMesh(Context(), encoded.header, with(prism.face_count() + 20, 18)).status();
  ExpectError(index, Reason::kMalformedEncoding, "faces");
  EXPECT_EQ(GetErrorDetail(index)->index, 2U);
  ExpectError(DecodeMesh(Context(), encoded.header, with(prism.face_count(), ~0U)).status(),
              Reason::kMalformedEncoding, "faces");
  ExpectError(DecodeMesh(Context(), encoded.header, with(0, 8)).status(),
              Reason::kMalformedEncoding, "mesh.corner_count");
  // 9 + 4 corners as 11 + 2: the sum is right, an arity is not.
  std::string bytes = with(0, 11);
  const std::uint32_t two = 2;
  std::memcpy(bytes.data() + 24 * prism.vertex_count() + 8, &two, 4);
  const absl::Status arity = DecodeMesh(Context(), encoded.header, bytes).status();
  ExpectError(arity, Reason::kMalformedEncoding, "faces");
  EXPECT_EQ(GetErrorDetail(arity)->index, 2U);
}

TEST(CheckHeaderTest, NamesTheFieldThatIsWrong) {
  const auto check = [](v1::MeshEncoding encoding, std::array<std::uint64_t, 4> counts) {
    return CheckHeader(Limits(), Header(encoding, counts));
  };
  const auto packed = v1::MESH_ENCODING_PACKED;
  const auto draco = v1::MESH_ENCODING_DRACO;
  EXPECT_TRUE(check(packed, {8, 6, 24, 312}).ok());
  EXPECT_TRUE(check(v1::MESH_ENCODING_UNSPECIFIED, {8, 6, 24, 312}).ok());
  EXPECT_TRUE(check(draco, {8, 6, 24, 312}).ok());
  EXPECT_TRUE(check(draco, {0, 0, 0, 1}).ok());
  ExpectError(check(static_cast<v1::MeshEncoding>(4), {8, 6, 24, 312}), Reason::kMalformedRequest,
              "mesh.encoding");
  ExpectError(check(packed, {0, 6, 24, 120}), Reason::kMalformedRequest, "mesh.vertex_count");
  ExpectError(check(packed, {8, 0, 24, 288}), Reason::kMalformedRequest, "mesh.face_count");
  ExpectError(check(packed, {8, 6, 0, 216}), Reason::kMalformedRequest, "mesh.corner_count");
  ExpectError(check(packed, {8, 6, 17, 284}), Reason::kMalformedRequest, "mesh.corner_count");
  ExpectError(check(draco, {8, 6, 17, 284}), Reason::kMalformedRequest, "mesh.corner_count");
  ExpectError(check(packed, {8, 6, 24, 313}), Reason::kMalformedRequest, "mesh.byte_count");
  ExpectError(check(draco, {8, 6, 24, 0}), Reason::kMalformedRequest, "mesh.byte_count");
  const std::uint64_t most = 48 * 8 + 24 * 24 + (64 << 10);
  EXPECT_TRUE(check(draco, {8, 6, 24, most}).ok());
  ExpectError(check(draco, {8, 6, 24, most + 1}), Reason::kMalformedRequest, "mesh.byte_count");
}

TEST(CheckHeaderTest, HoldsClaimsAgainstTheLimits) {
  const Limits limits = {.max_vertices = 8, .max_corners = 24, .max_bytes = 312};
  const auto check = [&](std::array<std::uint64_t, 4> counts) {
    return CheckHeader(limits, Header(v1::MESH_ENCODING_DRACO, counts));
  };
  EXPECT_TRUE(check({8, 6, 24, 312}).ok());
  ExpectError(check({9, 6, 24, 312}), Reason::kLimitExceeded, "mesh.vertex_count");
  ExpectError(check({8, 6, 25, 312}), Reason::kLimitExceeded, "mesh.corner_count");
  ExpectError(check({8, 9, 0, 312}), Reason::kLimitExceeded, "mesh.face_count");
  ExpectError(check({8, 6, 24, 313}), Reason::kLimitExceeded, "mesh.byte_count");
  // Numbers whose products wrap around 2^64.
  const std::uint64_t huge = std::uint64_t{1} << 62;
  for (const v1::MeshEncoding encoding : {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO}) {
    ExpectError(CheckHeader({.max_vertices = ~0ULL, .max_corners = ~0ULL, .max_bytes = ~0ULL},
                            Header(encoding, {huge, huge, ~0ULL, 0xffffffffULL})),
                Reason::kLimitExceeded, "mesh.vertex_count");
  }
}

}  // namespace
}  // namespace limn::wire
