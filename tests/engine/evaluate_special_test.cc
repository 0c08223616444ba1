// SPDX-License-Identifier: MIT
// Evaluation where the answer is known otherwise: regular patches, vertices of two faces, frames.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "engine/limit/biquadratic.h"
#include "engine/limit/evaluate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::AtHalfEdge;
using oracle::Evaluated;
using oracle::RandomSurface;
using oracle::Samples;

TEST(Evaluate, RegularPatchesAreBiquadraticBSplines) {
  const DooSabinSurface surface = RandomSurface(oracle::TorusOfQuads(7, 5), 43);
  const HalfEdgeMesh& mesh = surface.mesh;
  const PolygonWalk walk(mesh);
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    const auto at = [&](Index g) { return surface.corners[g]; };
    const Index below = RotateCw(walk, mesh.twin(), h);
    const Index left = RotateCcw(walk, mesh.twin(), h);
    const BiquadraticNet net = {
        {{at(RotateCw(walk, mesh.twin(), below)), at(below), at(mesh.twin()[h])},
         {at(left), at(h), at(walk.Next(h))},
         {at(walk.Next(left)), at(walk.Prev(h)), at(walk.Next(walk.Next(h)))}}};
    for (const auto& [u, v] : {std::pair(0.0, 0.0), {1.0, 0.0}, {0.2, 0.7}, {1e-310, 1.0}}) {
      const Samples sample = Evaluated(surface, {AtHalfEdge(mesh, h, u, v)});
      const BiquadraticJet jet = EvaluateBiquadratic(net, u, v);
      EXPECT_LE(MaxAbs(sample.points[0] - jet.point), 1e-15);
      EXPECT_LE(MaxAbs(sample.du[0] - jet.du), 1e-15);
      EXPECT_LE(MaxAbs(sample.dv[0] - jet.dv), 1e-15);
    }
  }
}

// [ZC Eq. 1] has eigenvalue 3/4 there instead of 1/2: points are as good as elsewhere, the tangent
// plane is lost.
TEST(Evaluate, AtVerticesOfTwoFacesPointsAreExactAndNormalsZero) {
  const DooSabinSurface surface = RandomSurface(oracle::Pillow(5), 44);
  const oracle::DeepSurface deep =
      oracle::Refined(surface, oracle::DeepLevel(surface.mesh, 400'000));
  const oracle::GridParameters grid = oracle::AllOf(surface, deep);
  const Samples samples = Evaluated(surface, grid.parameters);
  for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
    ASSERT_LE(MaxAbs(samples.points[i] - deep.points[grid.vertices[i]]), 1e-14) << i;
    ASSERT_TRUE(IsFinite(samples.du[i]) && IsFinite(samples.dv[i])) << i;
  }
  for (Index h = 0; h < surface.mesh.half_edge_count(); ++h) {
    std::vector<SurfaceParameter> parameters = {AtHalfEdge(surface.mesh, h, 0, 0),
                                                AtHalfEdge(surface.mesh, h, 1e-20, 0),
                                                AtHalfEdge(surface.mesh, h, 0, 1e-20)};
    // Half as far, half again as steep.
    for (const int j : {40, 41, 1000, 1001, 1073}) {
      parameters.push_back(AtHalfEdge(surface.mesh, h, std::ldexp(1, -j), std::ldexp(1, -j)));
    }
    const Samples near = Evaluated(surface, parameters);
    EXPECT_EQ(near.normals[0], (Vec3{0, 0, 0}));
    for (const std::size_t i : {0, 1, 2}) {
      EXPECT_LE(MaxAbs(near.points[i] - near.points[0]), 1e-15);
      EXPECT_LE(MaxAbs(i == 2 ? near.dv[i] : near.du[i]), 1e-15);
    }
    for (const std::size_t i : {3, 5}) {
      EXPECT_LE(MaxAbs(near.du[i + 1] - 1.5 * near.du[i]), 1e-12 * MaxAbs(near.du[i + 1]));
    }
    EXPECT_TRUE(IsFinite(near.du[7]));
    EXPECT_GT(MaxAbs(near.du[7]), 1e100);
  }
}

TEST(Evaluate, NormalsAreUnitLengthAndPointOutward) {
  for (const char* name : {"cube", "dodecahedron", "octahedron"}) {
    const DooSabinSurface surface = oracle::InterpolatingSurface(oracle::ClosedMesh(name));
    const std::vector<SurfaceParameter> parameters = oracle::SomeParameters(surface.mesh, 1000, 45);
    const Samples samples = Evaluated(surface, parameters);
    Vec3 middle = {0, 0, 0};
    for (const Vec3& p : surface.corners) {
      middle += 1.0 / static_cast<double>(surface.corners.size()) * p;
    }
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      EXPECT_NEAR(Norm(samples.normals[i]), 1, 1e-14);
      EXPECT_GT(Dot(samples.normals[i], samples.points[i] - middle), 0);
      EXPECT_NEAR(Dot(samples.normals[i], samples.du[i]), 0, 1e-13);
      EXPECT_NEAR(Dot(samples.normals[i], samples.dv[i]), 0, 1e-13);
    }
  }
}

TEST(Evaluate, MovesWithAffineMaps) {
  const DooSabinSurface surface = RandomSurface(*GenerateMesh({.vertices = 60, .seed = 2}), 46);
  const std::vector<SurfaceParameter> parameters = oracle::SomeParameters(surface.mesh, 2000, 47);
  const auto linear = [](const Vec3& p) {
    return Vec3{2 * p.x + p.y, p.y - 0.5 * p.z, p.x + 3 * p.z};
  };
  DooSabinSurface mapped = surface;
  for (Vec3& p : mapped.corners) p = linear(p);
  const Samples before = Evaluated(surface, parameters);
  const Samples after = Evaluated(mapped, parameters);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    EXPECT_LE(MaxAbs(linear(before.points[i]) - after.points[i]), 1e-14);
    EXPECT_LE(MaxAbs(linear(before.du[i]) - after.du[i]), 1e-13);
    EXPECT_LE(MaxAbs(linear(before.dv[i]) - after.dv[i]), 1e-13);
  }
}

TEST(Evaluate, PointsAreInTheModelsFrame) {
  DooSabinSurface surface = RandomSurface(oracle::Prism(5), 48);
  const std::vector<SurfaceParameter> parameters = oracle::SomeParameters(surface.mesh, 500, 49);
  const Samples before = Evaluated(surface, parameters);
  const Vec3 origin = {1e6, -2e6, 3e7};
  surface.boundary.origin = origin;
  const Samples after = Evaluated(surface, parameters);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    EXPECT_EQ(after.points[i], before.points[i] + origin);
    EXPECT_EQ(after.du[i], before.du[i]);
    EXPECT_EQ(after.normals[i], before.normals[i]);
  }
}

}  // namespace
}  // namespace limn
