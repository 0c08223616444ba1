// SPDX-License-Identifier: MIT
// Round trips of every encoding, and what encoding refuses.
#include "proto/wire/mesh_codec.h"

#include <chrono>
#include <cstring>
#include <limits>

#include "proto/wire/draco_encoder.h"
#include "proto/wire/draco_reader.h"
#include "tests/wire/test_meshes.h"

namespace limn::wire {
namespace {

constexpr v1::MeshEncoding kLossless[] = {v1::MESH_ENCODING_UNSPECIFIED, v1::MESH_ENCODING_PACKED,
                                          v1::MESH_ENCODING_DRACO};
constexpr v1::MeshEncoding kAll[] = {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO,
                                     v1::MESH_ENCODING_DRACO_QUANTIZED};
constexpr std::uint32_t kSeed = 20240611;

std::vector<PolygonMesh> Meshes() {
  return {Tetrahedron(),
          Cube(),
          Prism(3),
          Prism(7),
          Prism(200),
          Torus(5, 4),
          Torus(40, 70),
          IrregularTorus(4, 5, kSeed),
          IrregularTorus(50, 60, kSeed)};
}

EncodedMesh Encode(const PolygonMesh& mesh, v1::MeshEncoding encoding, int bits = 16) {
  auto encoded = EncodeMesh(Context(), mesh, {.encoding = encoding, .quantization_bits = bits});
  EXPECT_TRUE(encoded.ok()) << encoded.status();
  return encoded.ok() ? *encoded : EncodedMesh();
}

PolygonMesh RoundTrip(const PolygonMesh& mesh, v1::MeshEncoding encoding, int bits = 16) {
  const EncodedMesh encoded = Encode(mesh, encoding, bits);
  auto decoded = DecodeMesh(Context(), encoded.header, encoded.bytes);
  EXPECT_TRUE(decoded.ok()) << decoded.status();
  return decoded.ok() ? *std::move(decoded) : PolygonMesh();
}

absl::Status EncodeError(const PolygonMesh& mesh, v1::MeshEncoding encoding) {
  return EncodeMesh(Context(), mesh, {.encoding = encoding}).status();
}

TEST(MeshCodecTest, LosslessEncodingsKeepEveryBitAndAllOrder) {
  for (const v1::MeshEncoding encoding : kLossless) {
    for (const PolygonMesh& mesh : Meshes()) {
      const PolygonMesh back = RoundTrip(mesh, encoding);
      EXPECT_TRUE(SameBits(back.positions, mesh.positions));
      EXPECT_EQ(back.face_begin, mesh.face_begin);
      EXPECT_EQ(back.corner_vertex, mesh.corner_vertex);
    }
  }
}

TEST(MeshCodecTest, LosslessEncodingsKeepUnusualDoubles) {
  using Limits64 = std::numeric_limits<double>;
  PolygonMesh mesh = Tetrahedron();
  mesh.positions[0] = {-0.0, 0.0, Limits64::denorm_min()};
  mesh.positions[1] = {-Limits64::denorm_min(), Limits64::max(), Limits64::lowest()};
  mesh.positions[2] = {Limits64::min(), Limits64::epsilon(), 1.0 / 3};
  mesh.positions[3] = {Limits64::infinity(), -1e-310, 0x1.fffffffffffffp-1};
  for (const v1::MeshEncoding encoding : kLossless) {
    EXPECT_TRUE(SameBits(RoundTrip(mesh, encoding).positions, mesh.positions));
  }
}

TEST(MeshCodecTest, LosslessEncodingsKeepNonManifoldMeshes) {
  // Three faces at edge 0-1, two of them in the same direction, and a face that comes twice.
  const PolygonMesh mesh = MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}},
                                    {{0, 1, 2}, {0, 1, 3, 4}, {1, 0, 3}, {2, 3, 4}, {2, 3, 4}});
  for (const v1::MeshEncoding encoding : kLossless) EXPECT_EQ(RoundTrip(mesh, encoding), mesh);
}

TEST(MeshCodecTest, HeaderTellsTheCountsOfTheMesh) {
  const PolygonMesh mesh = Prism(5);
  for (const v1::MeshEncoding encoding : kAll) {
    const EncodedMesh encoded = Encode(mesh, encoding);
    EXPECT_EQ(encoded.header.encoding(), encoding);
    EXPECT_EQ(encoded.header.vertex_count(), 10U);
    EXPECT_EQ(encoded.header.face_count(), 7U);
    EXPECT_EQ(encoded.header.corner_count(), 30U);
    EXPECT_EQ(encoded.header.byte_count(), encoded.bytes.size());
    EXPECT_TRUE(CheckHeader(Limits(), encoded.header).ok());
  }
  EXPECT_EQ(Encode(mesh, v1::MESH_ENCODING_UNSPECIFIED).header.encoding(),
            v1::MESH_ENCODING_PACKED);
}

TEST(MeshCodecTest, PackedLayoutIsPositionsAritiesCorners) {
  const PolygonMesh mesh = MakeMesh({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}, {{2, 0, 1}});
  const std::string bytes = Encode(mesh, v1::MESH_ENCODING_PACKED).bytes;
  ASSERT_EQ(bytes.size(), 9 * 8 + 4 * 4U);
  double positions[9];
  std::uint32_t numbers[4];
  std::memcpy(positions, bytes.data(), sizeof(positions));
  std::memcpy(numbers, bytes.data() + sizeof(positions), sizeof(numbers));
  EXPECT_THAT(positions, testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(numbers, testing::ElementsAre(3, 2, 0, 1));
  EXPECT_EQ(static_cast<unsigned char>(bytes[72]), 3) << "little-endian";
}

TEST(MeshCodecTest, AritiesAreMetadataUnlessAllFacesAreTriangles) {
  const DracoBounds bounds = {.max_vertices = 100, .max_triangles = 100, .max_bytes = 1 << 20};
  const auto read = [&](const PolygonMesh& mesh) {
    return *ReadDraco(Context(), Encode(mesh, v1::MESH_ENCODING_DRACO).bytes, bounds);
  };
  EXPECT_EQ(read(Tetrahedron())->GetMetadata(), nullptr);
  const auto prism = read(Prism(3));
  std::vector<std::uint8_t> entry;
  ASSERT_TRUE(prism->GetMetadata()->GetEntryBinary("limn.arities", &entry));
  EXPECT_THAT(entry,
              testing::ElementsAre(3, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0));
}

TEST(MeshCodecTest, QuantizedKeepsVertexOrderAndTheSetOfFaces) {
  for (const PolygonMesh& mesh : Meshes()) {
    const PolygonMesh back = RoundTrip(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED);
    EXPECT_EQ(FaceSet(back), FaceSet(mesh));
    EXPECT_LE(MaxDeviation(back.positions, mesh.positions), 8.0 / 65535 / 2 * 1.01);
  }
}

TEST(MeshCodecTest, QuantizedErrorIsHalfAStepOfTheGrid) {
  const PolygonMesh mesh = IrregularTorus(20, 30, kSeed);
  for (const int bits : {8, 12, 16, 20, 24, 30}) {
    const double half_step = 8.0 / (std::pow(2.0, bits) - 1) / 2;
    const double float_error = 4 * 8 * 0x1p-24;
    EXPECT_LE(MaxDeviation(RoundTrip(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED, bits).positions,
                           mesh.positions),
              half_step + float_error)
        << bits << " bits";
  }
}

TEST(MeshCodecTest, QuantizedErrorScalesWithTheModel) {
  for (const double scale : {1e-28, 1e-9, 1e-4, 1e6, 1e30}) {
    PolygonMesh mesh = IrregularTorus(6, 7, kSeed);
    for (Vec3& p : mesh.positions) p *= scale;
    EXPECT_LE(
        MaxDeviation(RoundTrip(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED).positions, mesh.positions),
        scale * 8 / 65535 / 2 * 1.02)
        << "scale " << scale;
  }
}

TEST(MeshCodecTest, QuantizedTakesModelsWithoutExtent) {
  PolygonMesh mesh = Cube();
  for (Vec3& p : mesh.positions) p = {5, -6, 7};
  EXPECT_EQ(RoundTrip(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED).positions, mesh.positions);
}

TEST(MeshCodecTest, QuantizedKeepsOpenMeshesComponentsAndVerticesOfSeveralFans) {
  PolygonMesh open = Torus(6, 6);
  open.face_begin.resize(30);
  open.corner_vertex.resize(open.face_begin.back());
  // Two tetrahedra that share vertex 3, and one on its own.
  const PolygonMesh bow_tie = MakeMesh({{0, 0, 0},
                                        {1, 0, 0},
                                        {0, 1, 0},
                                        {0, 0, 1},
                                        {0, 0, 2},
                                        {1, 0, 2},
                                        {0, 1, 2},
                                        {5, 0, 0},
                                        {6, 0, 0},
                                        {5, 1, 0},
                                        {5, 0, 1}},
                                       {{0, 2, 1},
                                        {0, 1, 3},
                                        {1, 2, 3},
                                        {2, 0, 3},
                                        {4, 5, 6},
                                        {4, 3, 5},
                                        {5, 3, 6},
                                        {6, 3, 4},
                                        {7, 9, 8},
                                        {7, 8, 10},
                                        {8, 9, 10},
                                        {9, 7, 10}});
  for (const PolygonMesh& mesh : {open, bow_tie}) {
    const PolygonMesh back = RoundTrip(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED);
    EXPECT_EQ(FaceSet(back), FaceSet(mesh));
    EXPECT_LE(MaxDeviation(back.positions, mesh.positions), 1e-3);
  }
}

// A fan from the first corner would repeat edge 0-2.
TEST(MeshCodecTest, QuantizedChoosesDiagonalsThatRepeatNoEdge) {
  const PolygonMesh pillow =
      MakeMesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}, {3, 2, 1, 0}});
  const PolygonMesh lid =
      MakeMesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}, {0, 2, 1}, {0, 3, 2}});
  // All fans of the hexagon repeat an edge of a triangle; 0-2, 2-4, 4-0 do not.
  const PolygonMesh hexagon = MakeMesh({{0, 0, 0},
                                        {1, 0, 0},
                                        {2, 1, 0},
                                        {2, 2, 0},
                                        {1, 2, 0},
                                        {0, 1, 0},
                                        {0, 0, 1},
                                        {1, 0, 1},
                                        {1, 1, 1}},
                                       {{0, 1, 2, 3, 4, 5}, {0, 3, 6}, {1, 4, 7}, {2, 5, 8}});
  for (const PolygonMesh& mesh : {pillow, lid, hexagon}) {
    EXPECT_EQ(FaceSet(RoundTrip(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED)), FaceSet(mesh));
  }
}

TEST(MeshCodecTest, QuantizedRefusesAFaceThatCannotBeCut) {
  const PolygonMesh mesh =
      MakeMesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}},
               {{0, 2, 4}, {1, 3, 5}, {0, 1, 2, 3}});
  const absl::Status status = EncodeError(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED);
  ExpectError(status, Reason::kInvalidOption, "faces");
  EXPECT_EQ(GetErrorDetail(status)->index, 2U);
  EXPECT_THAT(std::string(status.message()), testing::HasSubstr("MESH_ENCODING_PACKED"));
}

TEST(MeshCodecTest, QuantizedRefusesNonManifoldEdges) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}};
  const PolygonMesh three_faces = MakeMesh(points, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  const PolygonMesh turned = MakeMesh(points, {{0, 1, 2, 3}, {0, 1, 4}});
  for (const PolygonMesh& mesh : {three_faces, turned}) {
    const absl::Status status = EncodeError(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED);
    ExpectError(status, Reason::kNonManifoldEdge, "faces");
    EXPECT_EQ(GetErrorDetail(status)->index, mesh.face_count() - 1);
  }
}

TEST(MeshCodecTest, QuantizedRefusesRepeatedAndIsolatedVertices) {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 2, 2}};
  ExpectError(
      EncodeError(MakeMesh(points, {{0, 1, 2, 0, 3, 4}}), v1::MESH_ENCODING_DRACO_QUANTIZED),
      Reason::kRepeatedVertex, "faces");
  ExpectError(
      EncodeError(MakeMesh(points, {{0, 1, 1, 2, 3, 4}}), v1::MESH_ENCODING_DRACO_QUANTIZED),
      Reason::kRepeatedVertex, "faces");
  const absl::Status isolated =
      EncodeError(MakeMesh(points, {{0, 1, 2}, {2, 1, 4}}), v1::MESH_ENCODING_DRACO_QUANTIZED);
  ExpectError(isolated, Reason::kIsolatedVertex, "vertices");
  EXPECT_EQ(GetErrorDetail(isolated)->index, 3U);
}

TEST(MeshCodecTest, QuantizedRefusesCoordinatesBeyondFloat) {
  for (const auto& [x, reason] : {std::pair{std::nan(""), Reason::kNonFiniteCoordinate},
                                  std::pair{INFINITY + 0.0, Reason::kNonFiniteCoordinate},
                                  std::pair{1e39, Reason::kCoordinateTooLarge},
                                  std::pair{3e38, Reason::kCoordinateTooLarge}}) {
    PolygonMesh mesh = Cube();
    mesh.positions[5].y = x;
    mesh.positions[6].y = -x;
    ExpectError(EncodeError(mesh, v1::MESH_ENCODING_DRACO_QUANTIZED), reason, "positions");
  }
}

TEST(MeshCodecTest, DracoKeepsSomeIsolatedVerticesAndRefusesMoreThanCorners) {
  PolygonMesh mesh = Tetrahedron();
  mesh.positions.resize(12, Vec3{1, 2, 3});
  EXPECT_EQ(RoundTrip(mesh, v1::MESH_ENCODING_DRACO), mesh);
  mesh.positions.resize(13, Vec3{1, 2, 3});
  ExpectError(EncodeError(mesh, v1::MESH_ENCODING_DRACO), Reason::kIsolatedVertex, "vertices");
  EXPECT_EQ(RoundTrip(mesh, v1::MESH_ENCODING_PACKED), mesh);
}

TEST(MeshCodecTest, EncodingRefusesBrokenFaces) {
  for (const v1::MeshEncoding encoding : kAll) {
    PolygonMesh mesh = Cube();
    mesh.corner_vertex[9] = 8;
    const absl::Status out_of_range = EncodeError(mesh, encoding);
    ExpectError(out_of_range, Reason::kIndexOutOfRange, "faces");
    EXPECT_EQ(GetErrorDetail(out_of_range)->index, 2U);
    mesh = Cube();
    mesh.face_begin[3] += 2;
    const absl::Status too_small = EncodeError(mesh, encoding);
    ExpectError(too_small, Reason::kFaceTooSmall, "faces");
    EXPECT_EQ(GetErrorDetail(too_small)->index, 3U);
    mesh = Cube();
    mesh.face_begin.back() += 1;
    ExpectError(EncodeError(mesh, encoding), Reason::kIndexOutOfRange, "faces");
    ExpectError(EncodeError(PolygonMesh(), encoding), Reason::kEmptyMesh, "vertices");
    ExpectError(EncodeError(MakeMesh({{0, 0, 0}}, {}), encoding), Reason::kEmptyMesh, "faces");
  }
}

TEST(MeshCodecTest, EncodingRefusesOptionsOutOfRange) {
  ExpectError(EncodeError(Cube(), static_cast<v1::MeshEncoding>(9)), Reason::kInvalidOption,
              "encoding");
  for (const int bits : {-1, 0, 7, 31}) {
    ExpectError(
        EncodeMesh(Context(), Cube(),
                   {.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED, .quantization_bits = bits})
            .status(),
        Reason::kInvalidOption, "quantization_bits");
  }
}

TEST(MeshCodecTest, StopsWhenTheJobIsStopped) {
  Context cancelled;
  cancelled.Cancel();
  Context late;
  late.set_deadline(Context::Clock::now() - std::chrono::seconds(1));
  for (const v1::MeshEncoding encoding : kAll) {
    const EncodedMesh encoded = Encode(Cube(), encoding);
    ExpectError(EncodeMesh(cancelled, Cube(), {.encoding = encoding}).status(), Reason::kCancelled);
    ExpectError(DecodeMesh(cancelled, encoded.header, encoded.bytes).status(), Reason::kCancelled);
    ExpectError(DecodeMesh(late, encoded.header, encoded.bytes).status(),
                Reason::kDeadlineExceeded);
  }
}

}  // namespace
}  // namespace limn::wire
