// SPDX-License-Identifier: MIT
// Catmull-Clark and Loop refinement of points.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "engine/mesh/generate.h"
#include "tests/oracle/creased_level.h"

namespace limn {
namespace {

using oracle::CreasedLevel;
using oracle::CreasedMesh;
using oracle::Creases;
using oracle::Rule;

class RefineTest : public testing::TestWithParam<std::tuple<Rule, std::string>> {
 protected:
  static Rule rule() { return std::get<0>(GetParam()); }
  static PolygonMesh Given() { return oracle::MeshFor(rule(), std::get<1>(GetParam())); }
};

void ExpectTheOraclesPoints(const PolygonMesh& given, Rule rule, const Creases& creases,
                            double bilinear) {
  CreasedLevel level(given, rule, creases);
  CreasedMesh expected = oracle::WithCreases(oracle::FromPolygonMesh(given), creases);
  const oracle::Real diagonal = oracle::Diagonal(expected.points);
  for (int k = 1; k <= 4 && expected.faces.size() < 3000; ++k) {
    SCOPED_TRACE(k);
    level.Refine(k == 1 ? bilinear : 0);
    expected = oracle::RefineCreased(expected, rule, k == 1 ? bilinear : 0);
    ASSERT_LE(oracle::MaxDistance(oracle::FromVec3(level.points), expected.points),
              2e-15 * diagonal);
  }
}

TEST_P(RefineTest, PointsAreTheTextbooks) {
  for (const BoundaryRule boundary :
       {BoundaryRule::kNone, BoundaryRule::kEdgeOnly, BoundaryRule::kEdgeAndCorner}) {
    ExpectTheOraclesPoints(Given(), rule(), {.boundary = boundary}, 0);
  }
}

TEST_P(RefineTest, CreasesAndCornersAreTheTextbooks) {
  const PolygonMesh given = Given();
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    for (const BoundaryRule boundary : {BoundaryRule::kEdgeOnly, BoundaryRule::kEdgeAndCorner}) {
      Creases creases = oracle::RandomCreases(given, seed);
      creases.boundary = boundary;
      ExpectTheOraclesPoints(given, rule(), creases, 0);
    }
  }
}

// Arrays of zeros must be as good as none.
TEST_P(RefineTest, TheFastPathHasTheBitsOfTheGeneralOne) {
  const PolygonMesh given = Given();
  CreasedLevel fast(given, rule(), {});
  CreasedLevel general(given, rule(), {});
  general.sharpness.edge.assign(general.mesh.edge_count(), 0);
  general.sharpness.vertex.assign(general.mesh.vertex_count(), 0);
  general.sharpness.lasting = true;
  for (std::size_t e = 0; e < general.mesh.edge_count(); ++e) {
    if (general.mesh.twin()[general.mesh.edge_half_edge()[e]] == kNoIndex) {
      general.sharpness.edge[e] = kSharpForever;
    }
  }
  for (std::size_t v = 0; v < general.mesh.vertex_count(); ++v) {
    if (general.mesh.valence(v) == 1) general.sharpness.vertex[v] = kSharpForever;
  }
  for (int k = 1; k <= 2; ++k) {
    fast.Refine();
    general.Refine();
    ASSERT_EQ(fast.points, general.points);
  }
}

std::string NameOf(const testing::TestParamInfo<std::tuple<Rule, std::string>>& info) {
  return (std::get<0>(info.param) == Rule::kLoop ? "Loop_" : "CatmullClark_") +
         std::get<1>(info.param);
}
INSTANTIATE_TEST_SUITE_P(All, RefineTest,
                         testing::Combine(testing::Values(Rule::kCatmullClark, Rule::kLoop),
                                          testing::ValuesIn(oracle::AllMeshNames())),
                         NameOf);

class BilinearShareTest : public testing::TestWithParam<std::string> {};

TEST_P(BilinearShareTest, BlendsTheSmoothPointsOfAStep) {
  const PolygonMesh given = oracle::AnyMesh(GetParam());
  for (const double bilinear : {0.5, 1.0}) {
    ExpectTheOraclesPoints(given, Rule::kCatmullClark, {}, bilinear);
    ExpectTheOraclesPoints(given, Rule::kCatmullClark, oracle::RandomCreases(given, 4), bilinear);
  }
}
INSTANTIATE_TEST_SUITE_P(All, BilinearShareTest, testing::ValuesIn(oracle::AllMeshNames()),
                         [](const auto& mesh) { return mesh.param; });

// A regular mesh of a bicubic B-spline, refined: knots halve.
TEST(Refine, RegularQuadsAreCubicBSplines) {
  CreasedLevel level(oracle::TorusOfQuads(7, 5), Rule::kCatmullClark, {});
  const Buffer<Vec3> before = level.points;
  const HalfEdgeMesh mesh = level.mesh;
  level.Refine();
  const PolygonWalk walk(mesh);
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    // Across the edge h: (1 6 1) / 8 times (1 1) / 2 along it.
    const auto at = [&](Index i) { return before[mesh.vertex()[i]]; };
    const Index t = mesh.twin()[h];
    const Vec3 one = at(walk.Prev(h)) + at(walk.Next(walk.Next(h)));
    const Vec3 other = at(walk.Prev(t)) + at(walk.Next(walk.Next(t)));
    const Vec3 expected = (1 / 16.0) * (6 * (at(h) + at(t)) + one + other);
    EXPECT_LE(MaxAbs(level.points[mesh.vertex_count() + mesh.edge()[h]] - expected), 1e-15);
  }
}

TEST(Refine, LoopWeightsAreThePublishedOnes) {
  EXPECT_NEAR(LoopNeighbourWeight(3), 9.0 / 16, 1e-15);
  EXPECT_NEAR(LoopNeighbourWeight(4), 31.0 / 64, 1e-15);
  EXPECT_NEAR(LoopNeighbourWeight(6), 3.0 / 8, 1e-15);
  // The same formula beyond the tables.
  EXPECT_NEAR(LoopNeighbourWeight(1000), 0.625 - std::pow(0.375 + std::cos(M_PI / 500) / 4, 2),
              1e-15);
}

TEST(Refine, HasTheSameBitsForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh given,
                            GenerateMesh({.kind = MeshKind::kDisk, .vertices = 10000, .seed = 3}));
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    const PolygonMesh mesh = rule == Rule::kLoop ? oracle::Triangulated(given) : given;
    for (const Creases& creases : {Creases(), oracle::RandomCreases(mesh, 5)}) {
      const auto refined = [&](int threads) {
        return oracle::WithThreads(threads, [&] {
          CreasedLevel level(mesh, rule, creases);
          level.Refine();
          level.Refine();
          return level.points;
        });
      };
      const Buffer<Vec3> one = refined(1);
      for (const int threads : {2, 5}) EXPECT_EQ(one, refined(threads));
    }
  }
}

TEST(Refine, RefusesSpansOfOtherSizes) {
  const CreasedLevel quads(oracle::Cube(), Rule::kCatmullClark, {});
  const CreasedLevel triangles(oracle::Octahedron(), Rule::kLoop, {});
  Buffer<Vec3> room(26);
  EXPECT_TRUE(
      RefineCatmullClark(Context(), quads.level(), quads.points, absl::MakeSpan(room)).ok());
  oracle::ExpectError(
      RefineCatmullClark(Context(), quads.level(), quads.points, absl::MakeSpan(room).subspan(1)),
      {Reason::kInternal});
  oracle::ExpectError(
      RefineCatmullClark(Context(), quads.level(), triangles.points, absl::MakeSpan(room)),
      {Reason::kInternal});
  EXPECT_TRUE(
      RefineLoop(Context(), triangles.level(), triangles.points, absl::MakeSpan(room).subspan(8))
          .ok());
  oracle::ExpectError(
      RefineLoop(Context(), triangles.level(), triangles.points, absl::MakeSpan(room)),
      {Reason::kInternal});
  oracle::ExpectError(
      RefineLoop(Context(), quads.level(), quads.points, absl::MakeSpan(room).subspan(6)),
      {Reason::kInvalidOption, "mesh.faces", 0});
}

TEST(Refine, EndsWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  const CreasedLevel quads(oracle::Cube(), Rule::kCatmullClark, {});
  const CreasedLevel triangles(oracle::Octahedron(), Rule::kLoop, {});
  Buffer<Vec3> room(26);
  oracle::ExpectError(
      RefineCatmullClark(cancelled, quads.level(), quads.points, absl::MakeSpan(room)),
      {Reason::kCancelled});
  oracle::ExpectError(
      RefineLoop(cancelled, triangles.level(), triangles.points, absl::MakeSpan(room).subspan(8)),
      {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
