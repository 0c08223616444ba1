// SPDX-License-Identifier: MIT
// Surfaces from feature values without plane faces: against the oracle's images and refinement, and
// what engine/constraints/features.h and engine/interpolate.h promise of them.
#include "engine/constraints/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/constraints/certificate.h"
#include "engine/interpolate.h"
#include "tests/engine/feature_planes_testing.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/features.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/tessellation.h"

namespace limn {
namespace {

InterpolateOptions With(FeatureValues values, std::uint32_t level = 2) {
  InterpolateOptions options = {.level = level};
  options.constraints.features = std::move(values);
  return options;
}

class FeatureSurfaceTest : public oracle::ClosedMeshTest {};

TEST_P(FeatureSurfaceTest, LimitPointsAreTheOracles) {
  const FeatureValues values = RandomValues(oracle::BuildOrDie(mesh_), 5);
  const double scale = static_cast<double>(oracle::Diagonal(given_.points));
  for (const int level : {1, 2, 3}) {
    if (level == 3 && mesh_.vertex_count() > 60) continue;
    LIMN_ASSERT_OK_AND_ASSIGN(
        const InterpolateResult result,
        Interpolate(context_, mesh_, With(values, static_cast<std::uint32_t>(level))));
    const oracle::FeatureTiling expected = oracle::FeatureLimit(given_, values, level);
    ASSERT_EQ(result.surface.vertex_count(), expected.points.size());
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.surface.positions), expected.points),
              1e-12L * scale);
    ASSERT_EQ(result.surface.face_count(), expected.tiling.faces.size());
    for (std::size_t q = 0; q < expected.tiling.faces.size(); ++q) {
      for (std::size_t i = 0; i < 4; ++i) {
        ASSERT_EQ(static_cast<int>(result.surface.face_vertices[4 * q + i]),
                  expected.tiling.faces[q][i]);
      }
    }
    EXPECT_EQ(result.rule, FirstRule::kFeatures);
    EXPECT_EQ(result.solve.sweeps, 0U);
    EXPECT_TRUE(result.solve.converged);
    EXPECT_EQ(result.control_positions, mesh_.positions);
  }
}

// With the defaults: the modified rule, with the given mesh as its control mesh.
TEST_P(FeatureSurfaceTest, DefaultsAreTheModifiedFirstStep) {
  InterpolateOptions plain = {.solve = {.max_sweeps = 0}, .level = 2};
  plain.constraints.interpolate.emplace();
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult expected, Interpolate(context_, mesh_, plain));
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Interpolate(context_, mesh_, With({})));
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.surface.positions),
                                oracle::FromVec3(expected.surface.positions)),
            1e-14L * oracle::Diagonal(given_.points));
}

TEST_P(FeatureSurfaceTest, VerticesOfValueZeroAreMet) {
  FeatureValues values = RandomValues(oracle::BuildOrDie(mesh_), 6);
  values.vertices = {{0, std::nullopt, 0}, {2, std::nullopt, 0}};
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result,
                            Interpolate(context_, mesh_, With(values)));
  const double rounding = 1e-14 * static_cast<double>(oracle::Diagonal(given_.points));
  EXPECT_LE(MaxAbs(result.surface.positions[0] - mesh_.positions[0]), rounding);
  EXPECT_LE(MaxAbs(result.surface.positions[2] - mesh_.positions[2]), rounding);
}

TEST_P(FeatureSurfaceTest, InterpolatedVerticesAndNormalsAreMet) {
  InterpolateOptions options = With(RandomValues(oracle::BuildOrDie(mesh_), 7));
  options.constraints.features->default_edge = 0.4;
  options.constraints.features->edges.clear();
  options.constraints.features->vertices.clear();
  options.constraints.features->default_vertex = 1;
  options.constraints.interpolate = {0, 2};
  // Vertices of two faces have no tangent plane.
  if (oracle::FacesAround(given_)[2] > 2) {
    options.constraints.normals = {{2, {0.2, 0.3, 1}}};
  }
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Interpolate(context_, mesh_, options));
  CertificateBuilder builder(mesh_.positions, options.constraints);
  builder.AddRun(0, result.surface.positions);
  builder.AddNormalRun(0, result.surface.normals);
  const Certificate certificate = builder.Finish();
  EXPECT_EQ(certificate.points_checked, 2U);
  EXPECT_LE(certificate.max_error, 1e-12 * certificate.bounding_box_diagonal);
  EXPECT_LE(certificate.max_normal_deviation, 1e-10);
  // Nothing is met that nobody asked for.
  EXPECT_GT(MaxAbs(result.surface.positions[1] - mesh_.positions[1]), 1e-3);
}

LIMN_FOR_CLOSED_MESHES(FeatureSurfaceTest);

double AreaOf(const Tessellation& surface) {
  double area = 0;
  for (std::size_t q = 0; q < surface.face_count(); ++q) {
    const auto at = [&](std::size_t i) {
      return surface.positions[surface.face_vertices[4 * q + i]];
    };
    area += 0.5 *
            (Norm(Cross(at(1) - at(0), at(2) - at(0))) + Norm(Cross(at(2) - at(0), at(3) - at(0))));
  }
  return area;
}

// The ends of the values' range, on the cube of (+-1, +-1, +-1): with EFV or VFV 0 everywhere it is
// the polyhedron, covered once; with 1 all images of a face are its centroid, and it is the dual
// one, the octahedron.
TEST(FeatureSurfaces, AtTheEndsOfTheRangeAreThePolyhedronAndItsDual) {
  const PolygonMesh cube = oracle::Moved(oracle::Cube(), 2, {-1, -1, -1});
  for (const FeatureValues& values : {FeatureValues{.default_edge = 0, .default_vertex = 1},
                                      FeatureValues{.default_edge = 0.7, .default_vertex = 0}}) {
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult sharp,
                              Interpolate(Context{}, cube, With(values, 4)));
    for (const Vec3& p : sharp.surface.positions) ASSERT_NEAR(MaxAbs(p), 1, 1e-15);
    for (std::size_t v = 0; v < 8; ++v) EXPECT_EQ(sharp.surface.positions[v], cube.positions[v]);
    EXPECT_NEAR(AreaOf(sharp.surface), 24, 1e-12);
  }
  LIMN_ASSERT_OK_AND_ASSIGN(
      const InterpolateResult dual,
      Interpolate(Context{}, cube, With({.default_edge = 1, .default_vertex = 1}, 4)));
  for (const Vec3& p : dual.surface.positions) {
    ASSERT_NEAR(std::fabs(p.x) + std::fabs(p.y) + std::fabs(p.z), 1, 1e-15);
  }
  EXPECT_NEAR(AreaOf(dual.surface), 4 * std::sqrt(3.0), 1e-12);
}

TEST(FeatureSurfaces, NothingIsInterpolatedOrCertifiedByDefault) {
  const PolygonMesh cube = oracle::Cube();
  CertificateBuilder builder(cube.positions, With({}).constraints);
  EXPECT_TRUE(builder.complete());
  EXPECT_EQ(builder.Finish().points_checked, 0U);
}

// A boundary curve is that of the given points, whatever the values.
TEST(FeatureSurfaces, BoundariesAreTheBSplineOfTheGivenPoints) {
  for (const std::string& name : oracle::OpenMeshNames()) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = oracle::OpenMesh(name);
    const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result,
                              Interpolate(Context{}, mesh, With(RandomValues(built, 8), 1)));
    const PolygonWalk walk(built);
    for (Index h = 0; h < built.half_edge_count(); ++h) {
      if (built.twin()[h] != kNoIndex) continue;
      const Vec3& a = mesh.positions[built.vertex()[h]];
      const Vec3& b = mesh.positions[built.vertex()[walk.Next(h)]];
      const Vec3& middle = result.surface.positions[built.vertex_count() + built.edge()[h]];
      EXPECT_LE(MaxAbs(middle - 0.5 * (a + b)), 1e-15);
    }
  }
}

// With plane faces it is in pieces, which end in corners at these faces' vertices.
TEST(FeatureSurfaces, BoundariesEndInCornersAtPlaneFaces) {
  PolygonMesh mesh = oracle::QuadPatch(5, 4);
  // Flat, so that faces have planes.
  for (Vec3& p : mesh.positions) p.z = 0.1 * p.x - 0.2 * p.y;
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  const PolygonWalk walk(built);
  for (const Index plane : {Index{0}, Index{2}}) {
    FeatureValues values = RandomValues(built, 14);
    values.faces = {{plane, FaceKind::kPlane}};
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result,
                              Interpolate(Context{}, mesh, With(values, 1)));
    std::size_t corners = 0;
    std::size_t others = 0;
    for (Index h = 0; h < built.half_edge_count(); ++h) {
      if (built.twin()[h] != kNoIndex) continue;
      const Index v = built.vertex()[h];
      const Index next = built.vertex()[walk.Next(h)];
      const Vec3& middle = result.surface.positions[built.vertex_count() + built.edge()[h]];
      const Vec3& at = mesh.positions[v];
      EXPECT_LE(MaxAbs(middle - 0.5 * (at + mesh.positions[next])), 1e-15);
      const absl::Span<const Index> face = mesh.face(plane);
      if (std::count(face.begin(), face.end(), v) > 0) {
        EXPECT_EQ(result.surface.positions[v], at);
        ++corners;
      } else if (built.valence(v) == 2) {
        // Half way between the curve's points before and after.
        Index before = built.fan()[built.fan_begin()[v]];
        for (Index g = 0; g < built.half_edge_count(); ++g) {
          if (built.twin()[g] == kNoIndex && built.vertex()[walk.Next(g)] == v) before = g;
        }
        const Vec3& from = mesh.positions[built.vertex()[before]];
        const Vec3 expected = 0.75 * at + 0.125 * (from + mesh.positions[next]);
        EXPECT_LE(MaxAbs(result.surface.positions[v] - expected), 1e-15) << v;
        ++others;
      }
    }
    EXPECT_GE(corners, 2U);
    EXPECT_GE(others, 6U);
  }
}

TEST(FeatureSurfaces, HaveTheSameBitsForAnyNumberOfThreads) {
  const PolygonMesh mesh = oracle::TorusOfQuads(120, 60);
  FeatureValues values = RandomValues(oracle::BuildOrDie(mesh), 9);
  values.faces = {{7, FaceKind::kPlane}};
  // Planar, so that it is left as it is.
  for (const bool plane : {false, true}) {
    PolygonMesh given = mesh;
    if (!plane) values.faces.clear();
    if (plane) {
      values.faces = {{7, FaceKind::kPlane}};
      const absl::Span<const Index> f = given.face(7);
      given.positions[f[3]] =
          given.positions[f[0]] + (given.positions[f[2]] - given.positions[f[1]]);
    }
    const auto run = [&] { return Interpolate(Context{}, given, With(values)); };
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult one, oracle::WithThreads(1, run));
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult many, oracle::WithThreads(4, run));
    EXPECT_EQ(one.surface.positions, many.surface.positions);
    EXPECT_EQ(one.surface.normals, many.surface.normals);
  }
}

TEST(FeatureSurfaces, FarFromTheOriginAreTheSame) {
  const Vec3 far = {1e5, -3e5, 2e5};
  const PolygonMesh near_mesh = oracle::Prism(6);
  const PolygonMesh far_mesh = oracle::Moved(near_mesh, 1, far);
  FeatureValues values = RandomValues(oracle::BuildOrDie(near_mesh), 10);
  values.faces = {{0, FaceKind::kPlane}};
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult a,
                            Interpolate(Context{}, near_mesh, With(values)));
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult b,
                            Interpolate(Context{}, far_mesh, With(values)));
  for (std::size_t v = 0; v < a.surface.vertex_count(); ++v) {
    ASSERT_LE(MaxAbs(b.surface.positions[v] - far - a.surface.positions[v]), 1e-9);
    ASSERT_LE(MaxAbs(b.surface.normals[v] - a.surface.normals[v]), 1e-6);
  }
}

TEST(FeatureSurfaces, NormalsAtVerticesOfTwoFacesAreRefused) {
  const PolygonMesh mesh = oracle::CubeWithVertexOfValenceTwo();
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  Index two = 0;
  while (built.valence(two) != 2) ++two;
  InterpolateOptions options = With({});
  options.constraints.interpolate = {0, two};
  options.constraints.normals = {{0, {0, 0, 1}}, {two, {0, 0, 1}}};
  oracle::ExpectError(Interpolate(Context{}, mesh, options).status(),
                      {Reason::kInvalidOption, "constraints.normals[1].vertex", 1});
}

TEST(FeatureSurfaces, WhatContradictsThemIsRefused) {
  const PolygonMesh cube = oracle::Cube();
  const auto refusal = [&](const InterpolateOptions& options) {
    return Interpolate(Context{}, cube, options).status();
  };
  InterpolateOptions options = With({});
  options.rule = FirstRule::kStandard;
  oracle::ExpectError(refusal(options), {Reason::kInvalidOption, "solve.rule"});
  options = With({});
  options.fair = true;
  oracle::ExpectError(refusal(options), {Reason::kInvalidOption, "solve.fair"});
  for (const Scheme scheme : {Scheme::kCatmullClark, Scheme::kLoop}) {
    options = With({});
    options.scheme = scheme;
    oracle::ExpectError(refusal(options), {Reason::kInvalidOption, "constraints.features"});
    options = {.scheme = scheme, .rule = FirstRule::kFeatures};
    oracle::ExpectError(refusal(options), {Reason::kInvalidOption, "solve.rule"});
  }
  options = {.rule = FirstRule::kFeatures};
  oracle::ExpectError(refusal(options), {Reason::kInvalidOption, "solve.rule"});
  // Without interpolated vertices there are no normals.
  options = With({});
  options.constraints.normals = {{0, {0, 0, 1}}};
  oracle::ExpectError(refusal(options),
                      {Reason::kInvalidOption, "constraints.normals[0].vertex", 0});
  options = With({.edges = {{0, 99, std::nullopt, 0.5}}});
  oracle::ExpectError(refusal(options),
                      {Reason::kIndexOutOfRange, "constraints.features.edges[0].to", 0});
}

}  // namespace
}  // namespace limn
