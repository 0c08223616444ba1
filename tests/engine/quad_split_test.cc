// SPDX-License-Identifier: MIT
#include "engine/mesh/quad_split.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "engine/mesh/generate.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/tessellation.h"

namespace limn {
namespace {

using oracle::Face;
using oracle::Tiling;

std::vector<Face> Quads(absl::Span<const Index> vertices) {
  std::vector<Face> quads;
  for (std::size_t q = 0; q + 3 < vertices.size(); q += 4) {
    Face face;
    for (std::size_t i = q; i < q + 4; ++i) face.push_back(static_cast<int>(vertices[i]));
    quads.push_back(face);
  }
  return quads;
}

// The split of quads, built from its faces as any mesh.
HalfEdgeMesh Rebuilt(const Tiling& tiling) {
  PolygonMesh mesh;
  mesh.positions.resize(static_cast<std::size_t>(tiling.vertex_count));
  for (const Face& face : tiling.faces) {
    mesh.AddFace(std::vector<Index>(face.begin(), face.end()));
  }
  return oracle::BuildOrDie(mesh);
}

class QuadSplitTest : public oracle::ClosedMeshTest {};

TEST_P(QuadSplitTest, IsTheOraclesAtEveryLevel) {
  HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  Tiling tiling = oracle::TilingOf(given_);
  const int euler = oracle::EulerCharacteristic(tiling);
  for (int level = 1; level <= 4 && tiling.faces.size() < 20000; ++level) {
    SCOPED_TRACE(level);
    Buffer<Index> quads(4 * mesh.half_edge_count());
    ASSERT_TRUE(QuadVertices(context_, mesh, absl::MakeSpan(quads)).ok());
    LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoQuads(context_, mesh));
    tiling = oracle::Split(tiling);
    ASSERT_EQ(Quads(quads), tiling.faces);
    ASSERT_EQ(Quads(mesh.vertex()), tiling.faces);
    ASSERT_EQ(mesh.vertex_count(), static_cast<std::size_t>(tiling.vertex_count));
    EXPECT_EQ(mesh.arity(), 4U);
    EXPECT_EQ(mesh.face_count(), tiling.faces.size());
    EXPECT_EQ(oracle::EulerCharacteristic(tiling), euler);
    EXPECT_EQ(static_cast<int>(mesh.vertex_count()) - static_cast<int>(mesh.edge_count()) +
                  static_cast<int>(mesh.face_count()),
              euler);
  }
}

TEST_P(QuadSplitTest, HasTheTwinsAndEdgesThatBuildFinds) {
  HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  for (int level = 1; level <= 3; ++level) {
    SCOPED_TRACE(level);
    LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoQuads(context_, mesh));
    const HalfEdgeMesh rebuilt = Rebuilt(oracle::TilingAtLevel(given_, level));
    ASSERT_EQ(mesh.twin(), rebuilt.twin());
    ASSERT_EQ(mesh.edge(), rebuilt.edge());
    ASSERT_EQ(mesh.edge_half_edge(), rebuilt.edge_half_edge());
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      ASSERT_EQ(mesh.vertex()[mesh.vertex_half_edge()[v]], v);
    }
  }
}

LIMN_FOR_CLOSED_MESHES(QuadSplitTest);

TEST(QuadSplit, KeepsBoundaries) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh disk,
                            GenerateMesh({.kind = MeshKind::kDisk, .vertices = 150}));
  const HalfEdgeMesh mesh = oracle::BuildOrDie(disk);
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoQuads(Context(), mesh));
  const HalfEdgeMesh rebuilt = Rebuilt(oracle::TilingAtLevel(oracle::FromPolygonMesh(disk), 1));
  EXPECT_EQ(split.twin(), rebuilt.twin());
  EXPECT_EQ(split.edge(), rebuilt.edge());
  EXPECT_EQ(split.boundary_edge_count(), 2 * mesh.boundary_edge_count());
  for (std::size_t v = 0; v < split.vertex_count(); ++v) {
    // Along the boundary where there is one.
    const Index h = split.vertex_half_edge()[v];
    ASSERT_EQ(split.vertex()[h], v);
    ASSERT_EQ(split.twin()[h] == kNoIndex,
              rebuilt.twin()[rebuilt.vertex_half_edge()[v]] == kNoIndex);
  }
}

TEST(QuadSplit, IsTheSameForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                            GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 20000}));
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  const auto split = [&](int threads) {
    return oracle::WithThreads(threads, [&] { return SplitIntoQuads(Context(), built); });
  };
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh one, split(1));
  for (const int threads : {2, 5}) {
    LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh many, split(threads));
    EXPECT_EQ(one.vertex(), many.vertex());
    EXPECT_EQ(one.twin(), many.twin());
    EXPECT_EQ(one.edge(), many.edge());
    EXPECT_EQ(one.edge_half_edge(), many.edge_half_edge());
    EXPECT_EQ(one.vertex_half_edge(), many.vertex_half_edge());
  }
}

TEST(QuadSplit, EndsWhenTheJobIsCancelledOrLate) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Cube());
  const Context cancelled;
  cancelled.Cancel();
  oracle::ExpectError(SplitIntoQuads(cancelled, mesh).status(), {Reason::kCancelled});
  Context late;
  late.set_deadline(Context::Clock::now());
  oracle::ExpectError(SplitIntoQuads(late, mesh).status(), {Reason::kDeadlineExceeded});
}

}  // namespace
}  // namespace limn
