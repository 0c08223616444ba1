// SPDX-License-Identifier: MIT
// Surfaces from feature values without plane faces: against the oracle's images and refinement, and
// what engine/constraints/features.h and engine/interpolate.h promise of them.
#include "engine/constraints/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/constraints/certificate.h"
#include "engine/interpolate.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/features.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/tessellation.h"

namespace limn {
namespace {

// Values of all kinds: defaults, of elements, and of elements in faces.
FeatureValues RandomValues(const HalfEdgeMesh& mesh, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> value(0, 1);
  const PolygonWalk walk(mesh);
  FeatureValues values = {.default_edge = value(random), .default_vertex = value(random)};
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    const Index v = mesh.vertex()[h];
    if (random() % 2 == 0) {
      values.edges.push_back({v, mesh.vertex()[walk.Next(h)], mesh.face()[h], value(random)});
    }
    if (random() % 3 == 0) values.vertices.push_back({v, mesh.face()[h], value(random)});
    if (mesh.vertex_half_edge()[v] == h && random() % 3 == 0) {
      values.vertices.push_back({v, std::nullopt, value(random)});
    }
  }
  return values;
}

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

bool SameSurface(const DooSabinSurface& a, const DooSabinSurface& b) {
  return a.corners == b.corners && a.boundary.half_edge == b.boundary.half_edge &&
         a.boundary.start == b.boundary.start && a.boundary.end == b.boundary.end &&
         a.boundary.centre == b.boundary.centre && a.boundary.sharp == b.boundary.sharp;
}

TEST(FeatureSurfaces, ChangedValuesKeepConnectivityAndMemory) {
  const PolygonMesh mesh = oracle::Prism(7);
  const Context context;
  LIMN_ASSERT_OK_AND_ASSIGN(FeatureSurface surface,
                            FeatureSurface::Create(context, oracle::BuildOrDie(mesh)));
  Constraints constraints;
  const auto make = [&](const FeatureValues& values) {
    constraints.features = values;
    const absl::Status status =
        surface.Make(context, {.points = mesh.positions, .constraints = constraints});
    EXPECT_TRUE(status.ok()) << status;
  };
  const auto fresh = [&](const FeatureValues& values) {
    constraints.features = values;
    FeatureSurface other = *FeatureSurface::Create(context, oracle::BuildOrDie(mesh));
    EXPECT_TRUE(other.Make(context, {.points = mesh.positions, .constraints = constraints}).ok());
    return std::move(other).TakeSurface();
  };
  const FeatureValues first = RandomValues(surface.given(), 11);
  const FeatureValues second = RandomValues(surface.given(), 12);
  make(first);
  const Index* const twins = surface.surface().mesh.twin().data();
  const Vec3* const corners = surface.surface().corners.data();
  make(second);
  EXPECT_EQ(surface.surface().mesh.twin().data(), twins);
  EXPECT_EQ(surface.surface().corners.data(), corners);
  EXPECT_EQ(surface.cuts(), 0U);
  EXPECT_TRUE(SameSurface(surface.surface(), fresh(second)));

  // A plane face cuts, once; its neighbours' values only move points.
  FeatureValues plane = first;
  plane.faces = {{0, FaceKind::kPlane}};
  make(plane);
  EXPECT_EQ(surface.cuts(), 1U);
  const Index* const cut_twins = surface.surface().mesh.twin().data();
  plane.default_edge = 0.9;
  plane.edges = second.edges;
  make(plane);
  EXPECT_EQ(surface.cuts(), 1U);
  EXPECT_EQ(surface.surface().mesh.twin().data(), cut_twins);
  EXPECT_TRUE(SameSurface(surface.surface(), fresh(plane)));
  EXPECT_EQ(surface.given().twin().data(), twins);

  make(first);
  EXPECT_EQ(surface.cuts(), 2U);
  EXPECT_EQ(surface.surface().mesh.twin().data(), twins);
  EXPECT_TRUE(SameSurface(surface.surface(), fresh(first)));
}

TEST(FeatureSurfaces, AnErrorDoesNotSpoilTheNext) {
  const PolygonMesh mesh = oracle::Cube();
  const Context context;
  LIMN_ASSERT_OK_AND_ASSIGN(FeatureSurface surface,
                            FeatureSurface::Create(context, oracle::BuildOrDie(mesh)));
  Constraints constraints;
  constraints.features = FeatureValues{.faces = {{0, FaceKind::kPlane}}};
  const FeatureTask task = {.points = mesh.positions, .constraints = constraints};
  ASSERT_TRUE(surface.Make(context, task).ok());
  const Buffer<Vec3> corners = surface.surface().corners;
  constraints.features->default_edge = 2;
  EXPECT_FALSE(surface.Make(context, task).ok());
  const Context cancelled;
  cancelled.Cancel();
  constraints.features = FeatureValues{.faces = {{1, FaceKind::kPlane}}};
  EXPECT_EQ(surface.Make(cancelled, task).code(), absl::StatusCode::kCancelled);
  constraints.features = FeatureValues{.faces = {{0, FaceKind::kPlane}}};
  ASSERT_TRUE(surface.Make(context, task).ok());
  EXPECT_EQ(surface.surface().corners, corners);
}

// The cut mesh is too large for the limits of one call, which fails half way.
TEST(FeatureSurfaces, AnErrorWhileCuttingDoesNotSpoilTheNext) {
  const PolygonMesh mesh = oracle::Cube();
  const Context context;
  const Context small(Limits{.max_vertices = mesh.vertex_count()});
  const FeatureValues kinds[] = {
      {}, {.faces = {{0, FaceKind::kPlane}}}, {.faces = {{1, FaceKind::kPlane}}}};
  Constraints constraints;
  const FeatureTask task = {.points = mesh.positions, .constraints = constraints};
  for (const FeatureValues& before : kinds) {
    for (const FeatureValues& after : kinds) {
      LIMN_ASSERT_OK_AND_ASSIGN(FeatureSurface surface,
                                FeatureSurface::Create(context, oracle::BuildOrDie(mesh)));
      constraints.features = before;
      ASSERT_TRUE(surface.Make(context, task).ok());
      constraints.features = FeatureValues{.faces = {{4, FaceKind::kPlane}}};
      EXPECT_EQ(surface.Make(small, task).code(), absl::StatusCode::kResourceExhausted);
      constraints.features = after;
      ASSERT_TRUE(surface.Make(context, task).ok());
      LIMN_ASSERT_OK_AND_ASSIGN(FeatureSurface fresh,
                                FeatureSurface::Create(context, oracle::BuildOrDie(mesh)));
      ASSERT_TRUE(fresh.Make(context, task).ok());
      EXPECT_TRUE(SameSurface(surface.surface(), fresh.surface()));
    }
  }
}

// Wherever the time runs out.
TEST(FeatureSurfaces, ADeadlineInsideDoesNotSpoilTheNext) {
  const PolygonMesh mesh = oracle::TorusOfTriangles(40, 40);
  const Context context;
  LIMN_ASSERT_OK_AND_ASSIGN(FeatureSurface surface,
                            FeatureSurface::Create(context, oracle::BuildOrDie(mesh)));
  FeatureSurface fresh = *FeatureSurface::Create(context, oracle::BuildOrDie(mesh));
  Constraints one;
  one.features = FeatureValues{.faces = {{1, FaceKind::kPlane}, {77, FaceKind::kPlane}}};
  Constraints other;
  other.features = FeatureValues{.faces = {{50, FaceKind::kPlane}}};
  ASSERT_TRUE(fresh.Make(context, {.points = mesh.positions, .constraints = one}).ok());
  std::size_t stopped = 0;
  for (int i = 0; i < 60; ++i) {
    ASSERT_TRUE(surface.Make(context, {.points = mesh.positions, .constraints = one}).ok());
    ASSERT_TRUE(SameSurface(surface.surface(), fresh.surface()));
    Context late;
    late.set_deadline(Context::Clock::now() + std::chrono::microseconds(20 * i));
    if (!surface.Make(late, {.points = mesh.positions, .constraints = other}).ok()) ++stopped;
  }
  EXPECT_GT(stopped, 0U);
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
