// SPDX-License-Identifier: MIT
#include "engine/refine/doo_sabin_refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "engine/mesh/generate.h"
#include "engine/mesh/quad_split.h"
#include "engine/refine/harmonics.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::DooSabinMesh;
using oracle::Points;
using oracle::Tiling;

class DooSabinRefineTest : public oracle::ClosedMeshTest {};

TEST_P(DooSabinRefineTest, FirstStepIsEquationFour) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  std::vector<Vec3> corners(mesh.half_edge_count());
  ASSERT_TRUE(FirstRefinement(context_, mesh, mesh_.positions, absl::MakeSpan(corners)).ok());
  const Tiling tiling = oracle::TilingOf(given_);
  const DooSabinMesh expected = oracle::RefineFirst(oracle::Start(given_), tiling);
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(corners),
                                oracle::InTileOrder(expected, oracle::Split(tiling))),
            1e-14 * oracle::Diagonal(given_.points));
}

// From a first refined mesh with images anywhere, as no first step would leave them.
TEST_P(DooSabinRefineTest, EveryLevelIsEquationOne) {
  HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  LIMN_ASSERT_OK_AND_ASSIGN(const ExtraordinaryFans fans, FindExtraordinaryFans(context_, mesh));
  Tiling tiling = oracle::TilingOf(given_);
  DooSabinMesh expected = oracle::RefineFirst(oracle::Start(given_), tiling);
  tiling = oracle::Split(tiling);
  std::mt19937_64 random(77);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  Buffer<Vec3> corners(mesh.half_edge_count());
  for (Vec3& p : corners) p = {coordinate(random), coordinate(random), coordinate(random)};
  const std::vector<int> tile = oracle::TileOfVertex(expected, tiling);
  const Points start = oracle::FromVec3(corners);
  for (std::size_t v = 0; v < tile.size(); ++v) {
    expected.points[v] = start[static_cast<std::size_t>(tile[v])];
  }
  for (std::uint32_t k = 1; k < 4 && corners.size() < 6000; ++k) {
    SCOPED_TRACE(k);
    Buffer<Vec3> refined(4 * corners.size());
    ASSERT_TRUE(RefineDooSabin(context_, {.mesh = mesh, .fans = fans, .k = k}, corners,
                               absl::MakeSpan(refined))
                    .ok());
    LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoQuads(context_, mesh));
    corners = refined;
    expected = oracle::Refine(expected, tiling);
    tiling = oracle::Split(tiling);
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(corners), oracle::InTileOrder(expected, tiling)),
              1e-13);
  }
}

TEST_P(DooSabinRefineTest, FansAreTheFacesThatAreNotQuads) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  LIMN_ASSERT_OK_AND_ASSIGN(const ExtraordinaryFans fans, FindExtraordinaryFans(context_, mesh));
  std::vector<Index> expected;
  std::vector<std::size_t> sizes;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.valence(v) == 4) continue;
    expected.push_back(static_cast<Index>(v));
    sizes.push_back(mesh.valence(v));
  }
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh_.arity(f) == 4) continue;
    expected.push_back(static_cast<Index>(mesh.vertex_count() + mesh.edge_count() + f));
    sizes.push_back(mesh_.arity(f));
  }
  ASSERT_EQ(fans.vertex, expected);
  ASSERT_EQ(fans.begin.size(), sizes.size() + 1);
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoQuads(context_, mesh));
  const QuadWalk walk(split);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    ASSERT_EQ(fans.begin[i + 1] - fans.begin[i], sizes[i]);
    for (Index j = fans.begin[i]; j < fans.begin[i + 1]; ++j) {
      const Index after = j + 1 == fans.begin[i + 1] ? fans.begin[i] : j + 1;
      ASSERT_EQ(split.vertex()[fans.corner[j]], fans.vertex[i]);
      ASSERT_EQ(RotateCcw(walk, split.twin(), fans.corner[j]), fans.corner[after]);
    }
  }
}

LIMN_FOR_CLOSED_MESHES(DooSabinRefineTest);

TEST(DooSabinRefine, HarmonicsAreTheDiscreteFourierComponents) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  for (const std::size_t m : {2, 3, 4, 5, 7, 31, 32, 33, 100}) {
    SCOPED_TRACE(m);
    std::vector<Vec3> p(m);
    for (Vec3& q : p) q = {coordinate(random), coordinate(random), coordinate(random)};
    const Harmonics found = FirstHarmonics(m, [&](std::size_t i) { return p[i]; });
    oracle::Point t1;
    oracle::Point t2;
    const Points points = oracle::FromVec3(p);
    for (std::size_t i = 0; i < m; ++i) {
      const oracle::Real angle = 2 * std::numbers::pi_v<oracle::Real> * i / m;
      t1 = t1 + std::cos(angle) * points[i];
      t2 = t2 + std::sin(angle) * points[i];
    }
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3({found.mean, found.t1, found.t2}),
                                  {oracle::Centroid(points), t1, t2}),
              1e-13);
  }
}

TEST(DooSabinRefine, HasTheSameBitsForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(
      const PolygonMesh given,
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 20000, .seed = 3}));
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  const Context context;
  LIMN_ASSERT_OK_AND_ASSIGN(const ExtraordinaryFans fans, FindExtraordinaryFans(context, mesh));
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoQuads(context, mesh));
  const auto refine = [&](int threads) {
    return oracle::WithThreads(threads, [&] {
      std::vector<Vec3> m1(mesh.half_edge_count());
      std::vector<Vec3> m2(4 * m1.size());
      std::vector<Vec3> m3(4 * m2.size());
      EXPECT_TRUE(FirstRefinement(context, mesh, given.positions, absl::MakeSpan(m1)).ok());
      EXPECT_TRUE(
          RefineDooSabin(context, {.mesh = mesh, .fans = fans, .k = 1}, m1, absl::MakeSpan(m2))
              .ok());
      EXPECT_TRUE(
          RefineDooSabin(context, {.mesh = split, .fans = fans, .k = 2}, m2, absl::MakeSpan(m3))
              .ok());
      return m3;
    });
  };
  const std::vector<Vec3> one = refine(1);
  for (const int threads : {2, 5}) EXPECT_EQ(one, refine(threads));
}

TEST(DooSabinRefine, EndsWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  const PolygonMesh cube = oracle::Cube();
  const HalfEdgeMesh mesh = oracle::BuildOrDie(cube);
  std::vector<Vec3> m1(24);
  std::vector<Vec3> m2(96);
  oracle::ExpectError(FirstRefinement(cancelled, mesh, cube.positions, absl::MakeSpan(m1)),
                      {Reason::kCancelled});
  oracle::ExpectError(FindExtraordinaryFans(cancelled, mesh).status(), {Reason::kCancelled});
  oracle::ExpectError(
      RefineDooSabin(cancelled, {.mesh = mesh, .fans = {}, .k = 1}, m1, absl::MakeSpan(m2)),
      {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
