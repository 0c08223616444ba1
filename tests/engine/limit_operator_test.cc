// SPDX-License-Identifier: MIT
// The limit operator and the order in which it gathers.
#include "engine/stencil/limit_operator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "engine/mesh/generate.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/limits_of.h"

namespace limn {
namespace {

class LimitOperatorTest : public oracle::ClosedMeshTest {};

TEST_P(LimitOperatorTest, SlotsAreAPermutation) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  LIMN_ASSERT_OK_AND_ASSIGN(const LimitOperator limit,
                            LimitOperator::Make(context_, mesh, DooSabinModifiedStencil()));
  ASSERT_EQ(limit.vertex_count(), mesh.vertex_count());
  ASSERT_EQ(limit.face_count(), mesh.face_count());
  std::vector<Vec3> numbered(mesh.vertex_count());
  for (std::size_t v = 0; v < numbered.size(); ++v) numbered[v] = {static_cast<double>(v), 0, 0};
  std::vector<Vec3> slots(numbered.size(), Vec3{-1, -1, -1});
  std::vector<Vec3> back(numbered.size());
  ASSERT_TRUE(limit.ToSlots(context_, numbered, absl::MakeSpan(slots)).ok());
  ASSERT_TRUE(limit.FromSlots(context_, slots, absl::MakeSpan(back)).ok());
  EXPECT_EQ(back, numbered);
  std::sort(slots.begin(), slots.end(), [](const Vec3& a, const Vec3& b) { return a.x < b.x; });
  EXPECT_EQ(slots, numbered);
}

// The limit point is the centroid of the oracle's images by Eq. 4.
TEST_P(LimitOperatorTest, LimitsAreTheCentroidsOfTheImages) {
  const oracle::Tiling tiling = oracle::TilingOf(given_);
  const oracle::Points limits = oracle::LimitPoints(
      oracle::RefineFirst(oracle::Start(given_), tiling), oracle::Split(tiling));
  const std::vector<Vec3> points(mesh_.positions.begin(), mesh_.positions.end());
  const std::vector<Vec3> engine =
      oracle::LimitsOf(oracle::BuildOrDie(mesh_), DooSabinModifiedStencil(), points);
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(engine),
                                {limits.begin(), limits.begin() + engine.size()}),
            1e-14 * oracle::Diagonal(given_.points));
}

LIMN_FOR_CLOSED_MESHES(LimitOperatorTest);

// No built scheme has edge weights or several rows yet; the shape of the stencil promises both.
TEST(LimitOperator, WeighsEdgeNeighboursAndChoosesRowsByVertex) {
  const PolygonMesh mesh = oracle::Jittered(oracle::Prism(5), 9, 0.2);
  LimitStencil stencil;
  stencil.rows = {{.vertex = 0.25, .edges = 0.5, .faces = 0.25}, {.vertex = 1}};
  stencil.row_of.assign(mesh.vertex_count(), 0);
  stencil.row_of[3] = 1;
  EXPECT_TRUE(stencil.uses_edges());
  EXPECT_FALSE(DooSabinModifiedStencil().uses_edges());
  const std::vector<Vec3> p(mesh.positions.begin(), mesh.positions.end());
  const std::vector<Vec3> limits = oracle::LimitsOf(oracle::BuildOrDie(mesh), stencil, p);
  EXPECT_EQ(limits[3], p[3]);
  // Vertex 1 of the prism's lower ring: neighbours 0, 2 and 6; faces: the lower cap and the sides
  // from 0 to 1 and from 1 to 2.
  const Vec3 cap = 0.2 * (p[0] + p[1] + p[2] + p[3] + p[4]);
  const Vec3 side_a = 0.25 * (p[0] + p[1] + p[6] + p[5]);
  const Vec3 side_b = 0.25 * (p[1] + p[2] + p[7] + p[6]);
  const Vec3 expected =
      0.25 * p[1] + (0.5 / 3) * (p[0] + p[2] + p[6]) + (0.25 / 3) * (cap + side_a + side_b);
  EXPECT_LE(MaxAbs(limits[1] - expected), 1e-15);
}

TEST(LimitOperator, VisitsReturnTheLargestValue) {
  LIMN_ASSERT_OK_AND_ASSIGN(
      const PolygonMesh mesh,
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 9000, .seed = 2}));
  const Context context;
  LIMN_ASSERT_OK_AND_ASSIGN(
      const LimitOperator limit,
      LimitOperator::Make(context, oracle::BuildOrDie(mesh), DooSabinModifiedStencil()));
  std::vector<Vec3> points(mesh.vertex_count(), Vec3{0, 0, 0});
  std::vector<Vec3> centroids(mesh.face_count(), Vec3{0, 0, 0});
  std::vector<int> visits(mesh.vertex_count(), 0);
  for (const Index peak : {0U, 4097U, 8999U}) {
    double largest = 0;
    ASSERT_TRUE(limit
                    .VisitLimits(
                        context, points.data(), centroids.data(),
                        [&](Index slot, const Vec3& /*limit*/) {
                          ++visits[slot];
                          return slot == peak ? 7.0 : 1.0;
                        },
                        &largest)
                    .ok());
    EXPECT_EQ(largest, 7);
  }
  EXPECT_EQ(visits, std::vector<int>(visits.size(), 3));
}

TEST(LimitOperator, EndsWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  oracle::ExpectError(
      LimitOperator::Make(cancelled, oracle::BuildOrDie(oracle::Cube()), DooSabinModifiedStencil())
          .status(),
      {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
