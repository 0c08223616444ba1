// SPDX-License-Identifier: MIT
// Refinement of all three schemes against CGAL's: the same points, whatever their order.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "engine/refine/doo_sabin_refine.h"
#include "tests/oracle/creased_level.h"
#include "tests/peers/cgal.h"
#include "tests/peers/peer_meshes.h"

namespace limn {
namespace {

using oracle::CreasedLevel;
using oracle::Rule;
using peers::CgalRefined;
using peers::CgalScheme;

// Each point of either has one of the other at its place.
void ExpectSamePoints(absl::Span<const Vec3> ours, std::vector<Vec3> theirs, double tolerance) {
  ASSERT_EQ(ours.size(), theirs.size());
  std::vector<Vec3> sorted(ours.begin(), ours.end());
  const auto by_x = [](const Vec3& a, const Vec3& b) { return a.x < b.x; };
  std::sort(sorted.begin(), sorted.end(), by_x);
  std::sort(theirs.begin(), theirs.end(), by_x);
  const auto expect_near = [&](const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    for (const Vec3& p : from) {
      auto at = std::lower_bound(to.begin(), to.end(), Vec3{p.x - tolerance, 0, 0}, by_x);
      double nearest = std::numeric_limits<double>::infinity();
      for (; at != to.end() && at->x <= p.x + tolerance; ++at) {
        nearest = std::min(nearest, MaxAbs(*at - p));
      }
      ASSERT_LE(nearest, tolerance);
    }
  };
  expect_near(sorted, theirs);
  expect_near(theirs, sorted);
}

// Without symmetry, which would let points take each other's place.
PolygonMesh Given(const std::string& name) {
  return oracle::Jittered(peers::PeerMesh(name), 17, 0.05);
}
double ToleranceFor(const PolygonMesh& mesh) {
  double largest = 0;
  for (const Vec3& p : mesh.positions) largest = std::max(largest, MaxAbs(p));
  return 4e-15 * largest;
}

class CgalTest : public testing::TestWithParam<std::string> {};
class CgalClosedTest : public testing::TestWithParam<std::string> {};

void ExpectSameRefinement(const PolygonMesh& given, Rule rule) {
  CreasedLevel level(given, rule, {.boundary = BoundaryRule::kEdgeOnly});
  const CgalScheme scheme = rule == Rule::kLoop ? CgalScheme::kLoop : CgalScheme::kCatmullClark;
  for (int k = 1; k <= 3; ++k) {
    SCOPED_TRACE(k);
    level.Refine();
    ExpectSamePoints(level.points, CgalRefined(given, scheme, k), ToleranceFor(given));
  }
}

TEST_P(CgalTest, HasTheSameCatmullClarkRefinement) {
  ExpectSameRefinement(Given(GetParam()), Rule::kCatmullClark);
}

TEST_P(CgalTest, HasTheSameLoopRefinement) {
  ExpectSameRefinement(oracle::Triangulated(Given(GetParam())), Rule::kLoop);
}

// CGAL cuts faces off at boundaries; closed meshes only.
TEST_P(CgalClosedTest, HasTheSameDooSabinRefinement) {
  const Context context;
  const PolygonMesh given = Given(GetParam());
  HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  LIMN_ASSERT_OK_AND_ASSIGN(const ExtraordinaryFans fans, FindExtraordinaryFans(context, mesh));
  Buffer<Vec3> corners(mesh.half_edge_count());
  ASSERT_TRUE(
      FirstRefinement(context, mesh, given.positions, absl::MakeSpan(corners), FirstRule::kStandard)
          .ok());
  for (std::uint32_t k = 1; k <= 3; ++k) {
    SCOPED_TRACE(k);
    ExpectSamePoints(corners, CgalRefined(given, CgalScheme::kDooSabin, static_cast<int>(k)),
                     ToleranceFor(given));
    Buffer<Vec3> refined(4 * corners.size());
    ASSERT_TRUE(RefineDooSabin(context, {.mesh = mesh, .fans = fans, .k = k}, corners,
                               absl::MakeSpan(refined))
                    .ok());
    corners = std::move(refined);
    LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoQuads(context, mesh));
  }
}

std::vector<std::string> ClosedNames() {
  std::vector<std::string> names = peers::PeerMeshNames(oracle::ClosedMeshNames());
  std::erase_if(names, [](const std::string& name) {
    return oracle::BuildOrDie(peers::PeerMesh(name)).boundary_edge_count() > 0;
  });
  return names;
}
INSTANTIATE_TEST_SUITE_P(All, CgalTest,
                         testing::ValuesIn(peers::PeerMeshNames(oracle::AllMeshNames())),
                         [](const auto& mesh) { return peers::TestName(mesh.param); });
INSTANTIATE_TEST_SUITE_P(All, CgalClosedTest, testing::ValuesIn(ClosedNames()),
                         [](const auto& mesh) { return peers::TestName(mesh.param); });

}  // namespace
}  // namespace limn
