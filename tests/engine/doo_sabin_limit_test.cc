// SPDX-License-Identifier: MIT
#include "engine/limit/doo_sabin_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "engine/mesh/quad_split.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::DooSabinMesh;
using oracle::Points;
using oracle::Tiling;

struct Limits {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;
};

// M^k with images of the first step at random places, by the engine and by the oracle.
class Refined {
 public:
  Refined(const PolygonMesh& given, std::uint64_t seed)
      : mesh(oracle::BuildOrDie(given)), corners(mesh.half_edge_count()) {
    auto found = FindExtraordinaryFans(Context(), mesh);
    EXPECT_TRUE(found.ok());
    fans = *std::move(found);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> coordinate(-1, 1);
    for (Vec3& p : corners) p = {coordinate(random), coordinate(random), coordinate(random)};
    const oracle::Mesh start = oracle::FromPolygonMesh(given);
    tiling = oracle::TilingOf(start);
    expected = oracle::RefineFirst(oracle::Start(start), tiling);
    tiling = oracle::Split(tiling);
    SetCorners(corners);
  }

  void SetCorners(const Buffer<Vec3>& points) {
    corners = points;
    const std::vector<int> tile = oracle::TileOfVertex(expected, tiling);
    for (std::size_t v = 0; v < tile.size(); ++v) {
      const Vec3& p = corners[static_cast<std::size_t>(tile[v])];
      expected.points[v] = {p.x, p.y, p.z};
    }
  }

  void Refine() {
    Buffer<Vec3> refined(4 * corners.size());
    ASSERT_TRUE(RefineDooSabin(Context(), {.mesh = mesh, .fans = fans, .k = k}, corners,
                               absl::MakeSpan(refined))
                    .ok());
    corners = refined;
    LIMN_ASSERT_OK_AND_ASSIGN(mesh, SplitIntoQuads(Context(), mesh));
    ++k;
    expected = oracle::Refine(expected, tiling);
    tiling = oracle::Split(tiling);
  }

  Limits FindLimits(bool with_normals) const {
    Limits limits;
    limits.points.resize(mesh.vertex_count() + mesh.edge_count() + mesh.face_count());
    if (with_normals) limits.normals.resize(limits.points.size());
    EXPECT_TRUE(DooSabinLimit(Context(), {.mesh = mesh, .fans = fans, .k = k}, corners,
                              {.points = absl::MakeSpan(limits.points),
                               .normals = absl::MakeSpan(limits.normals)})
                    .ok());
    return limits;
  }

  HalfEdgeMesh mesh;
  ExtraordinaryFans fans;
  Buffer<Vec3> corners;
  std::uint32_t k = 1;
  DooSabinMesh expected;
  Tiling tiling;
};

class DooSabinLimitTest : public oracle::ClosedMeshTest {};

TEST_P(DooSabinLimitTest, PointsAreTheCentroidsOfTheFaces) {
  Refined refined(mesh_, 21);
  for (int level = 1; level <= 3 && refined.corners.size() < 6000; ++level) {
    SCOPED_TRACE(level);
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(refined.FindLimits(false).points),
                                  oracle::LimitPoints(refined.expected, refined.tiling)),
              1e-13);
    refined.Refine();
  }
}

TEST_P(DooSabinLimitTest, NormalsAreThoseOfDeepRefinement) {
  Refined refined(mesh_, 22);
  for (int level = 1; level <= 3 && refined.corners.size() < 3000; ++level) {
    SCOPED_TRACE(level);
    const Points normals = oracle::FromVec3(refined.FindLimits(true).normals);
    const Points deep = oracle::DeepNormals(refined.expected, refined.tiling);
    ASSERT_EQ(normals.size(), deep.size());
    for (std::size_t v = 0; v < deep.size(); ++v) {
      // Images at random places make some first harmonics nearly parallel.
      ASSERT_LE(oracle::Norm(normals[v] - deep[v]), 1e-9) << v;
    }
    refined.Refine();
  }
}

TEST_P(DooSabinLimitTest, PointsDoNotDependOnWhetherNormalsAreAskedFor) {
  Refined refined(mesh_, 23);
  EXPECT_EQ(refined.FindLimits(false).points, refined.FindLimits(true).points);
  refined.Refine();
  EXPECT_EQ(refined.FindLimits(false).points, refined.FindLimits(true).points);
}

TEST_P(DooSabinLimitTest, VerticesOnlyWritesOnlyTheVertices) {
  const Refined refined(mesh_, 24);
  const Limits all = refined.FindLimits(true);
  const std::size_t n = mesh_.vertex_count();
  const Vec3 mark = {9, 9, 9};
  std::vector<Vec3> points(n + 1, mark);
  std::vector<Vec3> normals(n + 1, mark);
  ASSERT_TRUE(DooSabinLimit(context_, {.mesh = refined.mesh, .fans = refined.fans, .k = 1},
                            refined.corners,
                            {.points = absl::MakeSpan(points),
                             .normals = absl::MakeSpan(normals),
                             .vertices_only = true})
                  .ok());
  for (std::size_t v = 0; v < n; ++v) {
    EXPECT_EQ(points[v], all.points[v]);
    EXPECT_EQ(normals[v], all.normals[v]);
  }
  EXPECT_EQ(points[n], mark);
  EXPECT_EQ(normals[n], mark);
}

// Every face that lies in a plane has that plane's normal, up or down.
TEST_P(DooSabinLimitTest, PlanarSurfacesStayPlanar) {
  Refined refined(mesh_, 25);
  const Vec3 normal = {2.0 / 7, 3.0 / 7, 6.0 / 7};
  Buffer<Vec3> flat = refined.corners;
  for (Vec3& p : flat) p = p - Dot(p, normal) * normal + 5.0 * normal;
  refined.SetCorners(flat);
  for (int level = 1; level <= 2; ++level) {
    const Limits limits = refined.FindLimits(true);
    for (std::size_t v = 0; v < limits.points.size(); ++v) {
      EXPECT_NEAR(Dot(limits.points[v], normal), 5, 1e-13);
      if (limits.normals[v] == Vec3{0, 0, 0}) continue;
      EXPECT_LE(MaxAbs(Cross(limits.normals[v], normal)), 1e-8);
      EXPECT_NEAR(std::abs(Dot(limits.normals[v], normal)), 1, 1e-8);
    }
    refined.Refine();
  }
}

LIMN_FOR_CLOSED_MESHES(DooSabinLimitTest);

TEST(DooSabinLimit, VerticesOfTwoFacesHaveNoNormal) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(seed);
    Refined refined(oracle::Pillow(5), seed);
    for (int level = 1; level <= 2; ++level) {
      const Limits limits = refined.FindLimits(true);
      for (std::size_t v = 0; v < 5; ++v) EXPECT_EQ(limits.normals[v], (Vec3{0, 0, 0})) << v;
      // All others have one.
      for (std::size_t v = 5; v < limits.normals.size(); ++v) {
        EXPECT_NEAR(Norm(limits.normals[v]), 1, 1e-14);
      }
      refined.Refine();
    }
  }
}

TEST(DooSabinLimit, SurfacesCollapsedToALineOrAPointHaveNoNormals) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const Vec3& along : {Vec3{0.3, -0.7, 0.2}, Vec3{0, 0, 0}}) {
      SCOPED_TRACE(seed);
      Refined refined(oracle::Jittered(oracle::Prism(5), seed, 0.1), seed);
      Buffer<Vec3> line = refined.corners;
      for (Vec3& p : line) p = Vec3{1, 2, 3} + p.x * along;
      refined.SetCorners(line);
      for (int level = 1; level <= 3; ++level) {
        const Limits limits = refined.FindLimits(true);
        for (const Vec3& normal : limits.normals) ASSERT_EQ(normal, (Vec3{0, 0, 0}));
        refined.Refine();
      }
    }
  }
}

TEST(DooSabinLimit, NormalsDoNotDependOnTheSize) {
  Refined refined(oracle::Jittered(oracle::Prism(5), 2, 0.1), 31);
  const Buffer<Vec3> unit = refined.corners;
  const Limits expected = refined.FindLimits(true);
  for (const double size : {1e-300, 1e-200, 1e-100, 1e50, 1e90}) {
    SCOPED_TRACE(size);
    Buffer<Vec3> scaled = unit;
    for (Vec3& p : scaled) p *= size;
    refined.SetCorners(scaled);
    const Limits limits = refined.FindLimits(true);
    for (std::size_t v = 0; v < limits.points.size(); ++v) {
      ASSERT_LE(MaxAbs(limits.points[v] - size * expected.points[v]), 1e-14 * size);
      ASSERT_LE(MaxAbs(limits.normals[v] - expected.normals[v]), 1e-12);
    }
  }
}

TEST(DooSabinLimit, EndsWhenTheJobIsCancelled) {
  const Refined refined(oracle::Cube(), 1);
  std::vector<Vec3> points(26);
  const Context cancelled;
  cancelled.Cancel();
  oracle::ExpectError(
      DooSabinLimit(cancelled, {.mesh = refined.mesh, .fans = refined.fans, .k = 1},
                    refined.corners, {.points = absl::MakeSpan(points), .normals = {}}),
      {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
