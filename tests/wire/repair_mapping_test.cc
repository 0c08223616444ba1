// SPDX-License-Identifier: MIT
// The mapping of a repaired mesh comes out of its pieces as it went in.
#include "proto/wire/repair_mapping.h"

#include <gtest/gtest.h>

#include <numeric>
#include <tuple>

#include "engine/base/error.h"
#include "proto/wire/mesh_codec.h"
#include "tests/wire/test_meshes.h"

namespace limn::wire {
namespace {

Buffer<Index> Numbers(std::size_t count, Index first) {
  Buffer<Index> numbers(count);
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

TEST(RepairMappingTest, PiecesArePutTogetherAgain) {
  for (const auto& [vertices, faces, piece_bytes] : {std::tuple(1, 1, 4),
                                                     {1000, 500, 4},
                                                     {1000, 500, 1001},
                                                     {7, 0, 8},
                                                     {3, 5, 1 << 20},
                                                     {2, 3, 0}}) {
    const Buffer<Index> vertex = Numbers(static_cast<std::size_t>(vertices), 0x01020304);
    const Buffer<Index> face = Numbers(static_cast<std::size_t>(faces), 7);
    MappingReader reader(vertex, face, static_cast<std::size_t>(piece_bytes));
    MappingCollector collector;
    while (reader.has_next()) {
      v1::RepairReport piece;
      reader.Next(&piece);
      const std::size_t size = piece.original_vertex().size() + piece.original_face().size();
      EXPECT_GT(size, 0U);
      EXPECT_LE(size, static_cast<std::size_t>(std::max(4, piece_bytes)));
      collector.Add(piece);
    }
    v1::Summary summary;
    summary.mutable_repair()->set_faces_reoriented(3);
    collector.MoveTo(&summary);
    EXPECT_EQ(summary.repair().faces_reoriented(), 3U);
    EXPECT_EQ(MappingElements(summary.repair().original_vertex()), vertex);
    EXPECT_EQ(MappingElements(summary.repair().original_face()), face);
    EXPECT_EQ(summary.repair().original_vertex()[0], '\x04');
  }
}

TEST(RepairMappingTest, NothingIsPutIntoASummaryWithoutRepair) {
  MappingCollector collector;
  v1::RepairReport piece;
  piece.set_original_vertex("abcd");
  collector.Add(piece);
  v1::Summary summary;
  collector.MoveTo(&summary);
  EXPECT_FALSE(summary.has_repair());
}

// Faces of fewer than three corners, for a mesh that is to be repaired.

PolygonMesh WithSmallFaces() {
  PolygonMesh mesh = Torus(5, 4);
  mesh.AddFace({0, 1});
  mesh.AddFace({});
  mesh.AddFace({5});
  return mesh;
}

TEST(RepairMappingTest, SmallFacesTravelPackedOnRequestOnly) {
  const PolygonMesh mesh = WithSmallFaces();
  const auto encoded = EncodeMesh(Context(), mesh, {.any_arity = true});
  ASSERT_TRUE(encoded.ok()) << encoded.status();
  const auto decoded = DecodeMesh(Context(), encoded->header, encoded->bytes, {.any_arity = true});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(*decoded, mesh);

  const absl::Status refused = EncodeMesh(Context(), mesh).status();
  EXPECT_EQ(GetErrorDetail(refused)->reason, Reason::kFaceTooSmall);
  EXPECT_NE(refused.message().find("--repair"), std::string_view::npos) << refused;
  EXPECT_EQ(GetErrorDetail(DecodeMesh(Context(), encoded->header, encoded->bytes).status())->reason,
            Reason::kMalformedEncoding);
  for (const v1::MeshEncoding draco :
       {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    EXPECT_EQ(
        GetErrorDetail(EncodeMesh(Context(), mesh, {.encoding = draco, .any_arity = true}).status())
            ->reason,
        Reason::kFaceTooSmall);
  }
}

TEST(RepairMappingTest, ClaimsOfSmallFacesAreHeldAgainstTheLimits) {
  v1::MeshHeader header;
  header.set_encoding(v1::MESH_ENCODING_PACKED);
  header.set_vertex_count(3);
  header.set_face_count(10);
  header.set_corner_count(4);
  header.set_byte_count(3 * 24 + 4 * 14);
  EXPECT_EQ(GetErrorDetail(CheckHeader({}, header))->field, "mesh.corner_count");
  EXPECT_TRUE(CheckHeader({}, header, {.any_arity = true}).ok());
  EXPECT_EQ(GetErrorDetail(CheckHeader({.max_corners = 9}, header, {.any_arity = true}))->field,
            "mesh.face_count");
}

}  // namespace
}  // namespace limn::wire
