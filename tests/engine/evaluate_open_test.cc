// SPDX-License-Identifier: MIT
// Evaluation of surfaces with boundary: vertices of one face and of many, next to extraordinary
// faces, at the boundary itself.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/limit/evaluate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/open_meshes.h"

namespace limn {
namespace {

using oracle::AllOf;
using oracle::AtHalfEdge;
using oracle::DeepSurface;
using oracle::Evaluated;
using oracle::GridParameters;
using oracle::RandomSurface;
using oracle::Refined;
using oracle::RefinedParameter;
using oracle::RefinedSurface;
using oracle::Samples;

constexpr std::size_t kDeepQuads = 200'000;

// Boundary vertices of 5, 16 and 40 faces beside those of 1 to 6 that OpenMeshNames has.
const char* const kFan = "LargeHalfFan";
const char* const kSharp = "Sharp";
std::vector<std::string> Names() {
  std::vector<std::string> names = oracle::OpenMeshNames();
  for (const int faces : {5, 16, 40}) names.push_back(kFan + std::to_string(faces));
  // And the same with sharp vertices, as plane faces make them.
  for (std::size_t i = names.size(); i-- > 0;) names.push_back(kSharp + names[i]);
  return names;
}
PolygonMesh MeshOf(const std::string& name) {
  if (name.starts_with(kSharp)) return MeshOf(name.substr(std::string(kSharp).size()));
  if (!name.starts_with(kFan)) return oracle::OpenMesh(name);
  return oracle::HalfFan(std::stoi(name.substr(std::string(kFan).size())));
}
DooSabinSurface SurfaceOf(const std::string& name) {
  return name.starts_with(kSharp) ? oracle::RandomSharpSurface(MeshOf(name), 61)
                                  : RandomSurface(MeshOf(name), 61);
}

class EvaluateOpenTest : public testing::TestWithParam<std::string> {
 protected:
  EvaluateOpenTest() : surface_(SurfaceOf(GetParam())) {}
  const DooSabinSurface surface_;
};

TEST_P(EvaluateOpenTest, AgreesWithDeepRefinement) {
  const DeepSurface deep = Refined(surface_, oracle::DeepLevel(surface_.mesh, kDeepQuads));
  const GridParameters grid = AllOf(surface_, deep);
  const Samples samples = Evaluated(surface_, grid.parameters);
  for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
    const SurfaceParameter& p = grid.parameters[i];
    ASSERT_LE(MaxAbs(samples.points[i] - deep.points[grid.vertices[i]]), 1e-14)
        << p.face << " " << p.corner << " " << p.u << " " << p.v;
    ASSERT_LE(MaxAbs(samples.normals[i] - deep.normals[grid.vertices[i]]), 1e-8)
        << p.face << " " << p.corner << " " << p.u << " " << p.v;
  }
}

TEST_P(EvaluateOpenTest, IsTheSameSurfaceAfterRefinement) {
  const DooSabinSurface refined = RefinedSurface(surface_);
  std::vector<SurfaceParameter> coarse = oracle::SomeParameters(surface_.mesh, 3000, 62);
  std::erase_if(coarse, [](const SurfaceParameter& p) {
    return std::max(p.u, p.v) == 0.5 || std::min(p.u, p.v) == 0.5;
  });
  std::vector<SurfaceParameter> fine;
  for (const SurfaceParameter& p : coarse) fine.push_back(RefinedParameter(surface_, p));
  const Samples a = Evaluated(surface_, coarse);
  const Samples b = Evaluated(refined, fine);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    ASSERT_LE(MaxAbs(a.points[i] - b.points[i]), 1e-14) << i;
    const Vec3 u = 2 * b.du[i];
    const Vec3 v = 2 * b.dv[i];
    const Vec3 du[4] = {u, -v, -u, v};
    ASSERT_LE(MaxAbs(a.du[i] - du[fine[i].corner]), 1e-13) << i;
  }
}

// The patches end in the curve, with its derivative along it.
TEST_P(EvaluateOpenTest, ReachesTheBoundaryCurve) {
  const BoundaryCurve& curve = surface_.boundary;
  const PolygonWalk walk(surface_.mesh);
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Index h = curve.half_edge[i];
    const Vec3 middle = 0.5 * (curve.start[i] + curve.end[i]);
    for (const double t : {0.0, 1e-300, 0.1, 0.25, 0.6, 1.0}) {
      const Samples at = Evaluated(
          surface_, {AtHalfEdge(surface_.mesh, h, t, 0), AtHalfEdge(surface_.mesh, h, t, 1e-300),
                     AtHalfEdge(surface_.mesh, walk.Next(h), 0, t),
                     AtHalfEdge(surface_.mesh, walk.Next(h), 1e-300, t)});
      const auto check = [&](std::size_t first, const Vec3& vertex, const Vec3& near) {
        const Vec3 expected = (1 - t) * (1 - t) * vertex + 2 * t * (1 - t) * near + t * t * middle;
        const Vec3 slope = 2 * ((1 - t) * (near - vertex) + t * (middle - near));
        for (const std::size_t j : {first, first + 1}) {
          EXPECT_LE(MaxAbs(at.points[j] - expected), 1e-14) << t;
          // Next to an extraordinary point only the direction along the side has this limit.
          if (j > first && t < 0.1) continue;
          EXPECT_LE(MaxAbs((first == 0 ? at.du[j] : at.dv[j]) - slope), 1e-13) << t;
        }
      };
      check(0, curve.centre[i], curve.start[i]);
      check(2, curve.centre[curve.next[i]], curve.end[i]);
    }
  }
}

TEST_P(EvaluateOpenTest, PassesThroughTheVerticesAndTheCurveToTheBit) {
  const PolygonMesh given = MeshOf(GetParam());
  const DooSabinSurface surface = oracle::InterpolatingSurface(given);
  std::vector<SurfaceParameter> parameters;
  for (Index h = 0; h < surface.mesh.half_edge_count(); ++h) {
    parameters.push_back(AtHalfEdge(surface.mesh, h, 0, 0));
  }
  const Samples samples = Evaluated(surface, parameters);
  const auto diagonal = static_cast<double>(oracle::Diagonal(oracle::FromVec3(given.positions)));
  for (Index h = 0; h < parameters.size(); ++h) {
    const Vec3& vertex = given.positions[surface.mesh.vertex()[h]];
    EXPECT_LE(MaxAbs(samples.points[h] - vertex), 1e-15 * diagonal);
    if (surface.mesh.twin()[h] != kNoIndex) continue;
    EXPECT_EQ(samples.points[h], vertex);
  }
}

INSTANTIATE_TEST_SUITE_P(Open, EvaluateOpenTest, testing::ValuesIn(Names()),
                         [](const auto& mesh) { return mesh.param; });

// Two sheets that share a boundary see it in opposite directions.
TEST(EvaluateOpen, NeighboursShareTheirBoundaryToTheBit) {
  const DooSabinSurface left = RandomSurface(oracle::QuadPatch(4, 3), 63);
  // The mirror image: half-edge a -> b becomes b -> a.
  PolygonMesh mirrored = oracle::QuadPatch(4, 3);
  for (std::size_t f = 0; f < mirrored.face_count(); ++f) {
    std::reverse(mirrored.corner_vertex.begin() + mirrored.face_begin[f],
                 mirrored.corner_vertex.begin() + mirrored.face_begin[f + 1]);
  }
  DooSabinSurface right = RandomSurface(mirrored, 64);
  const PolygonWalk left_walk(left.mesh);
  const PolygonWalk right_walk(right.mesh);
  std::size_t shared = 0;
  for (std::size_t i = 0; i < left.boundary.size(); ++i) {
    for (std::size_t j = 0; j < right.boundary.size(); ++j) {
      const Index h = left.boundary.half_edge[i];
      const Index g = right.boundary.half_edge[j];
      if (left.mesh.vertex()[h] != right.mesh.vertex()[right_walk.Next(g)] ||
          left.mesh.vertex()[left_walk.Next(h)] != right.mesh.vertex()[g]) {
        continue;
      }
      ++shared;
      right.boundary.start[j] = left.boundary.end[i];
      right.boundary.end[j] = left.boundary.start[i];
      right.boundary.centre[j] = left.boundary.centre[left.boundary.next[i]];
    }
  }
  ASSERT_EQ(shared, left.boundary.size());
  right.boundary.origin = {3, 5, 7};
  for (std::size_t j = 0; j < right.boundary.size(); ++j) {
    const Index g = right.boundary.half_edge[j];
    for (const double t : {0.0, 1e-300, 0.1, 1.0 / 3, 0.5, 0.77, 1.0}) {
      const Samples mine = Evaluated(right, {AtHalfEdge(right.mesh, g, t, 0)});
      for (const Index h : left.boundary.half_edge) {
        const Index corner = left_walk.Next(h);
        if (left.mesh.vertex()[corner] != right.mesh.vertex()[g]) continue;
        const Samples theirs = Evaluated(left, {AtHalfEdge(left.mesh, corner, 0, t)});
        EXPECT_EQ(mine.points[0], theirs.points[0]) << t;
      }
    }
  }
}

}  // namespace
}  // namespace limn
