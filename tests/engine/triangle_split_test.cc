// SPDX-License-Identifier: MIT
#include "engine/mesh/triangle_split.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/generate.h"
#include "engine/mesh/quad_split.h"
#include "tests/oracle/creased.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/open_meshes.h"

namespace limn {
namespace {

using oracle::CreasedMesh;
using oracle::Face;

std::vector<Face> Triangles(absl::Span<const Index> vertices) {
  std::vector<Face> triangles;
  for (std::size_t t = 0; t + 2 < vertices.size(); t += 3) {
    Face face;
    for (std::size_t i = t; i < t + 3; ++i) face.push_back(static_cast<int>(vertices[i]));
    triangles.push_back(face);
  }
  return triangles;
}

// The edges of all half-edges, face by face.
std::vector<Index> EdgesOf(const CreasedMesh& mesh) {
  std::vector<Index> edges;
  for (const auto& sides : mesh.sides) edges.insert(edges.end(), sides.begin(), sides.end());
  return edges;
}

// Twins as the edges tell them.
std::vector<Index> TwinsOf(const CreasedMesh& mesh) {
  const std::vector<Index> edges = EdgesOf(mesh);
  std::vector<Index> twins(edges.size(), kNoIndex);
  std::vector<Index> first(mesh.edges.size(), kNoIndex);
  for (std::size_t h = 0; h < edges.size(); ++h) {
    Index& other = first[edges[h]];
    if (other == kNoIndex) {
      other = static_cast<Index>(h);
    } else {
      twins[h] = other;
      twins[other] = static_cast<Index>(h);
    }
  }
  return twins;
}

void ExpectTheOraclesSplits(const PolygonMesh& triangles) {
  const Context context;
  HalfEdgeMesh mesh = oracle::BuildOrDie(triangles);
  CreasedMesh expected = oracle::StartCreased(oracle::FromPolygonMesh(triangles));
  for (int level = 1; level <= 4 && expected.faces.size() < 20000; ++level) {
    SCOPED_TRACE(level);
    std::vector<Index> vertices(4 * mesh.half_edge_count());
    ASSERT_TRUE(TriangleVertices(context, mesh, absl::MakeSpan(vertices)).ok());
    LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoTriangles(context, mesh));
    expected = oracle::RefineCreased(expected, oracle::Rule::kLoop);
    ASSERT_EQ(Triangles(vertices), expected.faces);
    ASSERT_EQ(Triangles(mesh.vertex()), expected.faces);
    EXPECT_EQ(mesh.arity(), 3U);
    EXPECT_EQ(mesh.face_count(), expected.faces.size());
    ASSERT_EQ(mesh.vertex_count(), expected.points.size());
    ASSERT_EQ(std::vector<Index>(mesh.edge().begin(), mesh.edge().end()), EdgesOf(expected));
    ASSERT_EQ(std::vector<Index>(mesh.twin().begin(), mesh.twin().end()), TwinsOf(expected));
    for (std::size_t e = 0; e < mesh.edge_count(); ++e) {
      const Index h = mesh.edge_half_edge()[e];
      ASSERT_EQ(mesh.edge()[h], e);
      ASSERT_LT(h, mesh.twin()[h]);
    }
    const TriangleWalk walk(mesh);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      const Index h = mesh.vertex_half_edge()[v];
      ASSERT_EQ(mesh.vertex()[h], v);
      // The half-edge along the boundary, if the fan has one.
      Index at = RotateCcw(walk, mesh.twin(), h);
      while (at != kNoIndex && at != h) at = RotateCcw(walk, mesh.twin(), at);
      ASSERT_EQ(mesh.twin()[h] == kNoIndex, at == kNoIndex);
    }
  }
}

class TriangleSplitTest : public testing::TestWithParam<std::string> {};

TEST_P(TriangleSplitTest, IsTheOraclesAtEveryLevel) {
  ExpectTheOraclesSplits(oracle::Triangulated(oracle::ClosedMesh(GetParam())));
}
INSTANTIATE_TEST_SUITE_P(Closed, TriangleSplitTest, testing::ValuesIn(oracle::ClosedMeshNames()),
                         [](const auto& mesh) { return mesh.param; });

class OpenTriangleSplitTest : public testing::TestWithParam<std::string> {};

TEST_P(OpenTriangleSplitTest, KeepsBoundaries) {
  const PolygonMesh mesh = oracle::Triangulated(oracle::OpenMesh(GetParam()));
  ExpectTheOraclesSplits(mesh);
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoTriangles(Context(), built));
  EXPECT_EQ(split.boundary_edge_count(), 2 * built.boundary_edge_count());
}
INSTANTIATE_TEST_SUITE_P(Open, OpenTriangleSplitTest, testing::ValuesIn(oracle::OpenMeshNames()),
                         [](const auto& mesh) { return mesh.param; });

TEST(TriangleSplit, KeepsTheTrianglesOfAFaceTogether) {
  const PolygonMesh given = oracle::Triangulated(oracle::QuadPatch(2, 2));
  HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoTriangles(Context(), mesh));
  LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoTriangles(Context(), mesh));
  for (std::size_t f = 0; f < given.face_count(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      // The part of corner i is [16 f + 4 i, 16 f + 4 i + 4).
      EXPECT_EQ(mesh.vertex()[3 * (16 * f + 4 * i)], given.face(f)[i]);
    }
  }
}

TEST(TriangleSplit, RefusesOtherFacesWithAHint) {
  PolygonMesh strip = oracle::OpenMesh("Strip");
  const HalfEdgeMesh mesh = oracle::BuildOrDie(strip);
  std::vector<Index> vertices(4 * mesh.half_edge_count());
  for (const absl::Status& status :
       {RequireTriangles(mesh), SplitIntoTriangles(Context(), mesh).status(),
        TriangleVertices(Context(), mesh, absl::MakeSpan(vertices))}) {
    oracle::ExpectError(status, {Reason::kInvalidOption, "mesh.faces", 0});
    EXPECT_NE(status.message().find("2 faces"), std::string_view::npos) << status;
  }
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh quads, SplitIntoQuads(Context(), mesh));
  oracle::ExpectError(RequireTriangles(quads), {Reason::kInvalidOption, "mesh.faces", 0});
  EXPECT_TRUE(RequireTriangles(oracle::BuildOrDie(oracle::Octahedron())).ok());
}

TEST(TriangleSplit, TriangleWalkIsThePolygonWalk) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::TorusOfTriangles(4, 3));
  const PolygonWalk slow(mesh);
  const TriangleWalk fast(mesh);
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    EXPECT_EQ(fast.Face(h), slow.Face(h));
    EXPECT_EQ(fast.Next(h), slow.Next(h));
    EXPECT_EQ(fast.Prev(h), slow.Prev(h));
  }
  for (Index f = 0; f < mesh.face_count(); ++f) {
    EXPECT_EQ(fast.FaceBegin(f), slow.FaceBegin(f));
    EXPECT_EQ(fast.FaceEnd(f), slow.FaceEnd(f));
  }
}

TEST(TriangleSplit, IsTheSameForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                            GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 20000}));
  const HalfEdgeMesh built = oracle::BuildOrDie(oracle::Triangulated(mesh));
  const auto split = [&](int threads) {
    return oracle::WithThreads(threads, [&] { return SplitIntoTriangles(Context(), built); });
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

TEST(TriangleSplit, EndsWhenTheJobIsCancelledOrLate) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Octahedron());
  const Context cancelled;
  cancelled.Cancel();
  oracle::ExpectError(SplitIntoTriangles(cancelled, mesh).status(), {Reason::kCancelled});
  Context late;
  late.set_deadline(Context::Clock::now());
  oracle::ExpectError(SplitIntoTriangles(late, mesh).status(), {Reason::kDeadlineExceeded});
}

}  // namespace
}  // namespace limn
