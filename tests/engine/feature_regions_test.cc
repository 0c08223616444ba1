// SPDX-License-Identifier: MIT
// How plane regions lie inside of their boundary: once in convex faces, folded in others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "engine/interpolate.h"
#include "tests/engine/feature_planes_testing.h"

namespace limn {
namespace {

// A prism whose top is face 0, counter-clockwise as its outline.
PolygonMesh PrismOver(const std::vector<Vec3>& outline) {
  PolygonMesh mesh;
  const auto m = static_cast<Index>(outline.size());
  Buffer<Index> top;
  Buffer<Index> bottom;
  for (Index i = 0; i < m; ++i) {
    mesh.positions.push_back(outline[i] + Vec3{0, 0, 1});
    top.push_back(i);
    bottom.push_back(2 * m - 1 - i);
  }
  for (const Vec3& p : outline) mesh.positions.push_back(p);
  mesh.AddFace(top);
  mesh.AddFace(bottom);
  for (Index i = 0; i < m; ++i) {
    const Index next = (i + 1) % m;
    mesh.AddFace({next, i, m + i, m + next});
  }
  return mesh;
}

// Signed areas of the top's quads, whose plane is z = 1: those that are folded have negative ones.
struct TopAreas {
  double whole = 0;
  std::size_t folded = 0;
};

TopAreas AreasOfTop(const std::vector<Vec3>& outline, const FeatureValues& values) {
  const InterpolateResult result = Made(PrismOver(outline), values, 3);
  const Tessellation& surface = result.surface;
  double size = 0;
  for (const Vec3& p : outline) size = std::max(size, Norm(p - outline[0]));
  TopAreas areas;
  for (std::size_t q = 0; q < 16 * outline.size(); ++q) {
    const auto at = [&](std::size_t i) {
      return surface.positions[surface.face_vertices[4 * q + i]];
    };
    EXPECT_NEAR(at(0).z, 1, 1e-14);
    const double area = 0.5 * Cross(at(2) - at(0), at(3) - at(1)).z;
    areas.whole += area;
    if (area < -1e-13 * size * size) ++areas.folded;
  }
  return areas;
}

double AreaOf(const std::vector<Vec3>& outline) {
  double area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    area += 0.5 * Cross(outline[i], outline[(i + 1) % outline.size()]).z;
  }
  return area;
}

TEST(PlaneFaces, ConvexOnesDoNotFold) {
  constexpr std::uint64_t kSeed = 97;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> part(0, 1);
  for (int run = 0; run < 600; ++run) {
    // On an ellipse, anywhere: some corners are near to each other.
    std::vector<double> angles(3 + static_cast<std::size_t>(run) % 10);
    for (double& angle : angles) angle = 2 * std::numbers::pi * part(random);
    std::sort(angles.begin(), angles.end());
    std::vector<Vec3> outline;
    for (const double angle : angles) outline.push_back({3 * std::cos(angle), std::sin(angle), 0});
    FeatureValues values = Planes({0}, part(random));
    // All corners, or feet alone.
    if (run % 3 == 0) values = {.default_face = FaceKind::kPlane};
    const TopAreas areas = AreasOfTop(outline, values);
    ASSERT_EQ(areas.folded, 0U) << "run " << run;
    if (run % 3 != 0) continue;
    ASSERT_NEAR(areas.whole, AreaOf(outline), 1e-12);
  }
}

// The boundary is the outline all the same, so what folds covers nothing on the whole.
TEST(PlaneFaces, ConcaveOnesMayFoldInsideOfTheirBoundary) {
  const std::vector<Vec3> ell = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {2, 2, 0}, {2, 3, 0}, {0, 3, 0}};
  const std::vector<Vec3> bracket = {{0, 0, 0}, {5, 0, 0}, {5, 1, 0}, {1, 1, 0},
                                     {1, 4, 0}, {5, 4, 0}, {5, 5, 0}, {0, 5, 0}};
  for (const std::vector<Vec3>& outline : {ell, bracket}) {
    const TopAreas areas = AreasOfTop(outline, {.default_face = FaceKind::kPlane});
    EXPECT_NEAR(areas.whole, AreaOf(outline), 1e-12 * AreaOf(outline));
    EXPECT_GT(areas.folded, 0U);
  }
}

}  // namespace
}  // namespace limn
