// SPDX-License-Identifier: MIT
// One FeatureSurface for values that change again and again: what it keeps, and that an error
// leaves nothing behind.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <utility>

#include "engine/constraints/features.h"
#include "engine/interpolate.h"
#include "engine/limit/doo_sabin_limit.h"
#include "engine/mesh/quad_split.h"
#include "engine/refine/doo_sabin_refine.h"
#include "tests/engine/feature_planes_testing.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

bool SameSurface(const DooSabinSurface& a, const DooSabinSurface& b) {
  return a.corners == b.corners && a.boundary.half_edge == b.boundary.half_edge &&
         a.boundary.start == b.boundary.start && a.boundary.end == b.boundary.end &&
         a.boundary.centre == b.boundary.centre && a.boundary.sharp == b.boundary.sharp;
}

TEST(FeatureSurface, ChangedValuesKeepConnectivityAndMemory) {
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

// What belongs to the mesh - its fans, and the connectivity of finer steps - serves all values.
TEST(FeatureSurface, WhatWasMadeOfTheMeshServesChangedValues) {
  const PolygonMesh mesh = oracle::ClosedMesh("genus_three");
  const Context context;
  LIMN_ASSERT_OK_AND_ASSIGN(FeatureSurface surface,
                            FeatureSurface::Create(context, oracle::BuildOrDie(mesh)));
  LIMN_ASSERT_OK_AND_ASSIGN(const ExtraordinaryFans fans,
                            FindExtraordinaryFans(context, surface.surface().mesh));
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split,
                            SplitIntoQuads(context, surface.surface().mesh));
  Buffer<Vec3> refined(split.half_edge_count());
  Buffer<Vec3> points(split.vertex_count() + split.edge_count() + split.face_count());
  Constraints constraints;
  for (const std::uint64_t seed : {21, 22, 23}) {
    constraints.features = RandomValues(surface.given(), seed);
    ASSERT_TRUE(surface.Make(context, {.points = mesh.positions, .constraints = constraints}).ok());
    ASSERT_TRUE(RefineDooSabin(context, {.mesh = surface.surface().mesh, .fans = fans, .k = 1},
                               surface.surface().corners, absl::MakeSpan(refined))
                    .ok());
    ASSERT_TRUE(DooSabinLimit(context, {.mesh = split, .fans = fans, .k = 2}, refined,
                              {.points = absl::MakeSpan(points)})
                    .ok());
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult expected,
                              Interpolate(context, mesh, {.constraints = constraints, .level = 2}));
    EXPECT_EQ(points, expected.surface.positions) << seed;
  }
  EXPECT_EQ(surface.cuts(), 0U);
}

TEST(FeatureSurface, AnErrorDoesNotSpoilTheNext) {
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
TEST(FeatureSurface, AnErrorWhileCuttingDoesNotSpoilTheNext) {
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
TEST(FeatureSurface, ADeadlineInsideDoesNotSpoilTheNext) {
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

}  // namespace
}  // namespace limn
