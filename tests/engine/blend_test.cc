// SPDX-License-Identifier: MIT
// Normals, derivatives and points anywhere on Catmull-Clark and Loop surfaces.
#include "engine/constraints/blend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/constraints/blend_map.h"
#include "engine/constraints/certificate.h"
#include "engine/interpolate.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "tests/oracle/creased_level.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/primal_surface.h"

namespace limn {
namespace {

using oracle::Evaluated;
using oracle::ExpectError;
using oracle::Rule;
using oracle::Samples;

constexpr double kMet = 1e-10;

Scheme SchemeOf(Rule rule) { return rule == Rule::kLoop ? Scheme::kLoop : Scheme::kCatmullClark; }

double Size(const PolygonMesh& mesh) {
  return static_cast<double>(oracle::Diagonal(oracle::FromVec3(mesh.positions)));
}

Vec3 RandomVector(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> coordinate(-size, size);
  return {coordinate(random), coordinate(random), coordinate(random)};
}

Samples At(const InterpolateResult& result, const std::vector<SurfaceParameter>& parameters) {
  return Evaluated(std::get<PrimalSurface>(*result.patches), parameters);
}

class BlendTest : public testing::TestWithParam<std::tuple<Rule, std::string>> {
 protected:
  BlendTest() : random_(testing::UnitTest::GetInstance()->random_seed()) {
    mesh_ = oracle::Jittered(oracle::MeshFor(rule(), std::get<1>(GetParam())), 23, 0.02);
    size_ = Size(mesh_);
  }
  static Rule rule() { return std::get<0>(GetParam()); }
  static bool Loop() { return rule() == Rule::kLoop; }

  InterpolateOptions Options(std::uint32_t level = 2) const {
    return {.scheme = SchemeOf(rule()), .level = level, .keep_patches = true};
  }
  absl::StatusOr<InterpolateResult> Run(const InterpolateOptions& options) const {
    return Interpolate(Context(), mesh_, options);
  }
  InterpolateResult RunOrDie(const InterpolateOptions& options) const {
    absl::StatusOr<InterpolateResult> result = Run(options);
    EXPECT_TRUE(result.ok()) << result.status();
    return *std::move(result);
  }

  SurfaceParameter RandomPlace() {
    std::uniform_real_distribution<double> coordinate(0, 1);
    SurfaceParameter p = {.face = static_cast<Index>(random_() % mesh_.face_count())};
    p.corner = static_cast<Index>(random_() % mesh_.arity(p.face));
    p.u = coordinate(random_);
    p.v = coordinate(random_);
    if (Loop() && p.u + p.v > 1) std::tie(p.u, p.v) = std::pair(1 - p.u, 1 - p.v);
    return p;
  }

  // Vertices that are met, and meant to be, to within the tolerance.
  void ExpectVerticesStay(const InterpolateResult& result,
                          const std::vector<Index>& but = {}) const {
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      if (std::find(but.begin(), but.end(), v) != but.end()) continue;
      ASSERT_LE(Norm(result.surface.positions[v] - mesh_.positions[v]), 2 * kMet * size_) << v;
    }
  }

  PolygonMesh mesh_;
  double size_ = 0;
  std::mt19937_64 random_;
};

// By evaluation, and by the vertex of the tessellation that is there.
TEST_P(BlendTest, PointsAndNormalsAreMetAnywhere) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  for (int i = 0; i < 6; ++i) {
    SurfaceParameter place = RandomPlace();
    const Index h = mesh.face_begin()[place.face] + place.corner;
    // A vertex of T^2.
    std::size_t vertex = mesh.vertex_count() + mesh.edge()[h];
    if (Loop()) {
      std::tie(place.u, place.v) = std::pair(0.5, 0.0);
    } else {
      std::tie(place.u, place.v) = std::pair(0.5, 0.5);
      vertex = mesh.vertex_count() + 3 * mesh.edge_count() + mesh.face_count() +
               mesh.half_edge_count() + h;
    }
    const InterpolateResult plain = RunOrDie(Options());
    const Samples before = At(plain, {place});
    InterpolateOptions options = Options();
    SurfaceConstraint& wish = options.constraints.surface_points.emplace_back();
    wish.parameter = place;
    if (i % 3 != 1) wish.point = before.points[0] + RandomVector(random_, 0.03 * size_);
    if (i % 3 != 0) wish.normal = before.normals[0] + RandomVector(random_, 0.4);
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Run(options));
    const Vec3 aim = wish.point.value_or(before.points[0]);
    const Samples after = At(result, {place});
    EXPECT_LE(Norm(after.points[0] - aim), kMet * size_);
    EXPECT_LE(Norm(result.surface.positions[vertex] - aim), kMet * size_);
    if (wish.normal) {
      EXPECT_LE(AngleBetweenLines(after.normals[0], *wish.normal), kMet);
      EXPECT_LE(AngleBetweenLines(result.surface.normals[vertex], *wish.normal), 100 * kMet);
    }
    ExpectVerticesStay(result);
    ASSERT_TRUE(result.blend.has_value());
    EXPECT_EQ(result.blend->constraints, 1U);
  }
}

TEST_P(BlendTest, DerivativesAreMetAnywhere) {
  for (int i = 0; i < 6; ++i) {
    const SurfaceParameter place = RandomPlace();
    const Samples before = At(RunOrDie(Options()), {place});
    InterpolateOptions options = Options();
    SurfaceConstraint& wish = options.constraints.surface_points.emplace_back();
    wish.parameter = place;
    const double length = Norm(before.du[0]) + Norm(before.dv[0]);
    if (i % 3 != 1) wish.derivative_u = before.du[0] + RandomVector(random_, 0.2 * length);
    if (i % 3 != 0) wish.derivative_v = before.dv[0] + RandomVector(random_, 0.2 * length);
    const absl::StatusOr<InterpolateResult> result = Run(options);
    ASSERT_TRUE(result.ok()) << result.status();
    const Samples after = At(*result, {place});
    EXPECT_LE(Norm(after.points[0] - before.points[0]), kMet * size_);
    if (wish.derivative_u) {
      EXPECT_LE(Norm(after.du[0] - *wish.derivative_u), kMet * Norm(*wish.derivative_u));
    }
    if (wish.derivative_v) {
      EXPECT_LE(Norm(after.dv[0] - *wish.derivative_v), kMet * Norm(*wish.derivative_v));
    }
    ExpectVerticesStay(*result);
  }
}

// At levels below, at and above that of the control points that move.
TEST_P(BlendTest, NormalsOfAllVerticesAreMetAtEveryLevel) {
  const InterpolateResult plain = RunOrDie(Options(0));
  for (std::uint32_t level = 0; level <= 3; ++level) {
    InterpolateOptions options = Options(level);
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      // Where it has a tangent plane.
      if (plain.surface.normals[v] == Vec3{0, 0, 0}) continue;
      const Vec3 turned = plain.surface.normals[v] + RandomVector(random_, 0.2);
      options.constraints.normals.push_back({v, v % 2 == 0 ? turned : -turned});
    }
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Run(options));
    for (const NormalConstraint& wish : options.constraints.normals) {
      ASSERT_LE(AngleBetweenLines(result.surface.normals[wish.vertex], wish.normal), kMet);
    }
    ExpectVerticesStay(result);
    EXPECT_EQ(result.blend->constraints, options.constraints.normals.size());
    EXPECT_EQ(result.surface.level, level);
  }
}

TEST_P(BlendTest, ANormalAndItsOppositeAreTheSameConstraint) {
  InterpolateOptions options = Options(1);
  options.constraints.normals = {{0, {0.3, 0.5, 0.7}}};
  const InterpolateResult one = RunOrDie(options);
  options.constraints.normals = {{0, {-0.3, -0.5, -0.7}}};
  EXPECT_EQ(RunOrDie(options).surface.positions, one.surface.positions);
}

// Levels below that of the control points that move keep their own bits too.
TEST_P(BlendTest, OutsideTheRegionNotABitChanges) {
  for (std::uint32_t level = 0; level <= 3; ++level) {
    const InterpolateResult plain = RunOrDie(Options(level));
    InterpolateOptions options = Options(level);
    options.constraints.normals = {{1, plain.surface.normals[1] + Vec3{0.1, 0.2, -0.1}}};
    if (plain.surface.normals[1] == Vec3{0, 0, 0}) return;
    const InterpolateResult result = RunOrDie(options);
    ASSERT_TRUE(result.blend.has_value());
    const PrimalSurface& surface = std::get<PrimalSurface>(*result.patches);
    std::vector<bool> near(surface.mesh.vertex_count(), false);
    // Vertices of T^2 whose rings have moved.
    std::vector<Index> front = result.blend->moved;
    for (const Index v : front) near[v] = true;
    for (std::size_t h = 0; h < surface.mesh.half_edge_count(); ++h) {
      const std::size_t arity = surface.mesh.arity();
      for (std::size_t g = h - h % arity; g < h - h % arity + arity; ++g) {
        const Index w = surface.mesh.vertex()[g];
        if (std::binary_search(front.begin(), front.end(), w)) {
          near[surface.mesh.vertex()[h]] = true;
        }
      }
    }
    std::size_t same = 0;
    for (std::size_t v = 0; v < std::min(near.size(), plain.surface.positions.size()); ++v) {
      if (near[v]) continue;
      ++same;
      ASSERT_EQ(result.surface.positions[v], plain.surface.positions[v]) << v;
      ASSERT_EQ(result.surface.normals[v], plain.surface.normals[v]) << v;
    }
    EXPECT_GT(same + (level == 0 ? 1 : 0), mesh_.vertex_count() / 2);
    EXPECT_EQ(result.surface.face_vertices, plain.surface.face_vertices);
    EXPECT_EQ(result.control_positions, plain.control_positions);
  }
}

TEST_P(BlendTest, SameBitsForAnyNumberOfThreads) {
  InterpolateOptions options = Options(2);
  const InterpolateResult plain = RunOrDie(options);
  for (Index v = 0; v < mesh_.vertex_count(); v += 2) {
    if (plain.surface.normals[v] == Vec3{0, 0, 0}) continue;
    options.constraints.normals.push_back({v, plain.surface.normals[v] + Vec3{0.1, 0, 0.1}});
  }
  const auto run = [&] { return RunOrDie(options); };
  const InterpolateResult one = oracle::WithThreads(1, run);
  const InterpolateResult four = oracle::WithThreads(4, run);
  EXPECT_EQ(one.surface.positions, four.surface.positions);
  EXPECT_EQ(one.surface.normals, four.surface.normals);
}

// Three in one face, one of them next to an interpolated vertex.
TEST_P(BlendTest, WhatIsTooCloseIsMetTogether) {
  const Index face = static_cast<Index>(random_() % mesh_.face_count());
  const std::vector<SurfaceParameter> places = {
      {face, 0, 0.06, 0.08}, {face, 0, 0.4, 0.3}, {face, 0, 0.5, 0.45}};
  const Samples before = At(RunOrDie(Options()), places);
  InterpolateOptions options = Options();
  for (std::size_t i = 0; i < places.size(); ++i) {
    SurfaceConstraint& wish = options.constraints.surface_points.emplace_back();
    wish.parameter = places[i];
    wish.point = before.points[i] + RandomVector(random_, 0.002 * size_);
  }
  options.constraints.surface_points[1].normal = before.normals[1] + RandomVector(random_, 0.05);
  const absl::StatusOr<InterpolateResult> result = Run(options);
  ASSERT_TRUE(result.ok()) << result.status();
  const Samples after = At(*result, places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const SurfaceConstraint& wish = options.constraints.surface_points[i];
    EXPECT_LE(Norm(after.points[i] - *wish.point), kMet * size_) << i;
    if (wish.normal) {
      EXPECT_LE(AngleBetweenLines(after.normals[i], *wish.normal), kMet);
    }
  }
  ExpectVerticesStay(*result);
  EXPECT_EQ(result->blend->together, 3U);
}

TEST_P(BlendTest, ContradictionsAreRefusedByName) {
  const SurfaceParameter place = {0, 0, 0.4, 0.35};
  const Samples before = At(RunOrDie(Options()), {place});
  InterpolateOptions options = Options();
  for (int i = 0; i < 2; ++i) {
    SurfaceConstraint& wish = options.constraints.surface_points.emplace_back();
    wish.parameter = place;
    wish.point = before.points[0] + Vec3{0, 0, (0.01 + 0.01 * i) * size_};
  }
  const absl::Status status = Run(options).status();
  ExpectError(status, {Reason::kInvalidOption, "constraints.surface_points[0]", 0});
  EXPECT_NE(status.message().find("constraints.surface_points[1]"), std::string_view::npos)
      << status;
}

// A region given by the faces of T^2 within so many rings of a vertex.
std::vector<Index> FacesAround(const HalfEdgeMesh& mesh, Index vertex, int rings) {
  std::vector<bool> reached(mesh.vertex_count(), false);
  reached[vertex] = true;
  std::vector<Index> faces;
  const std::size_t arity = mesh.arity();
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<bool> next = reached;
    faces.clear();
    for (Index f = 0; f < mesh.face_count(); ++f) {
      bool touches = false;
      for (std::size_t i = 0; i < arity; ++i) touches |= reached[mesh.vertex()[arity * f + i]];
      if (!touches) continue;
      faces.push_back(f);
      for (std::size_t i = 0; i < arity; ++i) next[mesh.vertex()[arity * f + i]] = true;
    }
    reached = next;
  }
  return faces;
}

TEST_P(BlendTest, OnlyTheGivenRegionChanges) {
  const InterpolateResult plain = RunOrDie(Options(2));
  const PrimalSurface& surface = std::get<PrimalSurface>(*plain.patches);
  // T^1 for quads, T^0 for triangles.
  HalfEdgeMesh fine = surface.mesh;
  for (int k = Loop() ? 0 : 1; k < 2; ++k) {
    LIMN_ASSERT_OK_AND_ASSIGN(
        fine, Loop() ? SplitIntoTriangles(Context(), fine) : SplitIntoQuads(Context(), fine));
  }
  InterpolateOptions options = Options(2);
  SurfaceConstraint& wish = options.constraints.surface_points.emplace_back();
  wish.vertex = 2;
  wish.normal = plain.surface.normals[2] + Vec3{0.2, -0.1, 0.1};
  for (const int rings : {3, 4, 7}) {
    wish.region = FacesAround(fine, 2, rings);
    const absl::StatusOr<InterpolateResult> result = Run(options);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_LE(AngleBetweenLines(result->surface.normals[2], *wish.normal), kMet);
    ExpectVerticesStay(*result);
    std::vector<bool> inside(fine.vertex_count(), false);
    for (const Index f : wish.region) {
      for (std::size_t i = 0; i < fine.arity(); ++i) {
        inside[fine.vertex()[fine.arity() * f + i]] = true;
      }
    }
    for (std::size_t v = 0; v < inside.size(); ++v) {
      if (inside[v]) continue;
      ASSERT_EQ(result->surface.positions[v], plain.surface.positions[v]);
      ASSERT_EQ(result->surface.normals[v], plain.surface.normals[v]);
    }
  }
  wish.region = FacesAround(fine, 2, 2);
  // Everything is within two rings of it in a mesh so small.
  if (wish.region.size() == fine.face_count()) return;
  ExpectError(Run(options).status(),
              {Reason::kInvalidOption, "constraints.surface_points[0].region", 0});
}

TEST_P(BlendTest, WhatIsSharpStaysMet) {
  InterpolateOptions options = Options(1);
  options.constraints.creases = {
      {{mesh_.corner_vertex[0], mesh_.corner_vertex[1]}, {2.5F}},
      {{mesh_.corner_vertex[1], mesh_.corner_vertex[2]}, {kSharpForever}}};
  const InterpolateResult plain = RunOrDie(options);
  for (const Index v : {mesh_.corner_vertex[1], mesh_.corner_vertex[2], Index{0}}) {
    if (plain.surface.normals[v] == Vec3{0, 0, 0}) continue;
    const NormalConstraint wish = {v, plain.surface.normals[v] + RandomVector(random_, 0.2)};
    options.constraints.normals = {wish};
    const absl::StatusOr<InterpolateResult> result = Run(options);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_LE(AngleBetweenLines(result->surface.normals[v], wish.normal), kMet);
    ExpectVerticesStay(*result);
  }
}

// Far from the origin, where jobs run on points around one of their own.
TEST_P(BlendTest, PointsAreMetFarFromTheOrigin) {
  const Vec3 way = {1000 * size_, 0, 0};
  const SurfaceParameter place = {0, 0, 0.45, 0.4};
  mesh_ = oracle::Moved(mesh_, 1, way);
  const Samples before = At(RunOrDie(Options()), {place});
  InterpolateOptions options = Options();
  SurfaceConstraint& wish = options.constraints.surface_points.emplace_back();
  wish.parameter = place;
  wish.point = before.points[0] + Vec3{0, 0.01 * size_, 0};
  const InterpolateResult result = RunOrDie(options);
  EXPECT_LE(Norm(At(result, {place}).points[0] - *wish.point), 1e-9 * size_);
}

std::vector<std::string> Names() {
  return {"cube",           "dodecahedron", "torus_jittered_seed_5",
          "ngons_seed_2",   "antiprism_40", "TubeOfOneRing",
          "CubeWithoutLid", "TwoPatches",   "ShuffledPatch"};
}
std::string NameOf(const testing::TestParamInfo<std::tuple<Rule, std::string>>& info) {
  return (std::get<0>(info.param) == Rule::kLoop ? "Loop_" : "CatmullClark_") +
         std::get<1>(info.param);
}
INSTANTIATE_TEST_SUITE_P(All, BlendTest,
                         testing::Combine(testing::Values(Rule::kCatmullClark, Rule::kLoop),
                                          testing::ValuesIn(Names())),
                         NameOf);

// One in each face, so that every face is too close to its neighbours.
TEST(Blend, AsManyAsThereAreFacesAreMetTogether) {
  const PolygonMesh torus = oracle::Jittered(oracle::TorusOfQuads(40, 40), 3, 0.02);
  const double size = Size(torus);
  for (const Scheme scheme : {Scheme::kCatmullClark, Scheme::kLoop}) {
    const PolygonMesh mesh = scheme == Scheme::kLoop ? oracle::Triangulated(torus) : torus;
    InterpolateOptions options = {.scheme = scheme, .level = 0, .keep_patches = true};
    absl::StatusOr<InterpolateResult> result = Interpolate(Context(), mesh, options);
    ASSERT_TRUE(result.ok()) << result.status();
    std::vector<SurfaceParameter> places;
    for (Index f = 0; f < mesh.face_count(); ++f) places.push_back({f, 0, 0.4, 0.45});
    const Samples before = At(*result, places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      SurfaceConstraint& wish = options.constraints.surface_points.emplace_back();
      wish.parameter = places[i];
      wish.point = before.points[i] + (i % 2 == 0 ? 1e-3 : -1e-3) * size * before.normals[i];
    }
    result = Interpolate(Context(), mesh, options);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->blend->together, places.size());
    const Samples after = At(*result, places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      ASSERT_LE(Norm(after.points[i] - *options.constraints.surface_points[i].point), kMet * size);
    }
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      ASSERT_LE(Norm(result->surface.positions[v] - mesh.positions[v]), 2 * kMet * size) << v;
    }
  }
}

// Both sides of a crease turn, together with a normal next to it.
TEST(Blend, ACreaseTurnsAsAWholeBesideOtherConstraints) {
  const PolygonMesh torus = oracle::Jittered(oracle::TorusOfQuads(12, 12), 3, 0.02);
  for (const Scheme scheme : {Scheme::kCatmullClark, Scheme::kLoop}) {
    const PolygonMesh mesh = scheme == Scheme::kLoop ? oracle::Triangulated(torus) : torus;
    InterpolateOptions options = {.scheme = scheme, .level = 1, .keep_patches = true};
    // Along a row of vertices, with faces to both sides.
    const Index a = torus.corner_vertex[0];
    const Index b = torus.corner_vertex[1];
    options.constraints.creases = {{{a, b, b + (b - a)}, {kSharpForever}}};
    absl::StatusOr<InterpolateResult> result = Interpolate(Context(), mesh, options);
    ASSERT_TRUE(result.ok()) << result.status();
    const SurfaceParameter place = {0, 1, 0.2, 0.15};
    const Vec3 normal = At(*result, {place}).normals[0] + Vec3{0.02, -0.01, 0.03};
    const Vec3 at_crease = result->surface.normals[b] + Vec3{0.1, 0.05, -0.1};
    options.constraints.normals = {{b, at_crease}};
    options.constraints.surface_points = {{.parameter = place, .normal = normal}};
    result = Interpolate(Context(), mesh, options);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->blend->together, 2U);
    EXPECT_LE(AngleBetweenLines(result->surface.normals[b], at_crease), kMet);
    EXPECT_LE(AngleBetweenLines(At(*result, {place}).normals[0], normal), kMet);
  }
}

class BlendErrors : public testing::Test {
 protected:
  absl::Status StatusOf(const std::function<void(SurfaceConstraint&)>& change,
                        Scheme scheme = Scheme::kCatmullClark) const {
    InterpolateOptions options = {.scheme = scheme, .level = 0};
    options.constraints.surface_points.resize(2);
    options.constraints.surface_points[0] = {.vertex = 0, .normal = Vec3{1, 1, 1}};
    SurfaceConstraint& second = options.constraints.surface_points[1];
    second = {.parameter = SurfaceParameter{5, 1, 0.4, 0.5}, .normal = Vec3{0, 0, 1}};
    change(second);
    return Interpolate(
               Context(),
               scheme == Scheme::kLoop ? oracle::Triangulated(oracle::Cube()) : oracle::Cube(),
               options)
        .status();
  }
  void Expect(Reason reason, const std::string& member,
              const std::function<void(SurfaceConstraint&)>& change) const {
    ExpectError(StatusOf(change), {reason, "constraints.surface_points[1]" + member, 1});
  }
};

TEST_F(BlendErrors, EveryBadConstraintNamesItsField) {
  const Reason range = Reason::kIndexOutOfRange;
  const Reason invalid = Reason::kInvalidOption;
  const double nan = std::nan("");
  const double infinity = std::numeric_limits<double>::infinity();
  const auto at_vertex = [](SurfaceConstraint& c, Index v) {
    c.parameter.reset();
    c.vertex = v;
  };
  Expect(range, ".vertex", [&](auto& c) { at_vertex(c, 8); });
  Expect(invalid, ".vertex", [&](auto& c) { at_vertex(c, 0); });
  Expect(invalid, "", [&](auto& c) { c.vertex = 1; });
  Expect(invalid, "", [&](auto& c) { c.parameter.reset(); });
  Expect(range, ".parameter.face", [](auto& c) { c.parameter->face = 6; });
  Expect(range, ".parameter.corner", [](auto& c) { c.parameter->corner = 4; });
  for (const double bad : {nan, infinity, -1e-9, 1.0001}) {
    Expect(invalid, ".parameter.u", [bad](auto& c) { c.parameter->u = bad; });
    Expect(invalid, ".parameter.v", [bad](auto& c) { c.parameter->v = bad; });
  }
  Expect(invalid, "", [](auto& c) { c.normal.reset(); });
  Expect(invalid, ".normal", [](auto& c) { c.normal = {0, 0, 0}; });
  Expect(invalid, ".normal", [nan](auto& c) { c.normal = {0, nan, 0}; });
  Expect(invalid, ".point", [infinity](auto& c) { c.point = {infinity, 0, 0}; });
  Expect(invalid, ".derivative_u", [](auto& c) { c.derivative_u = Vec3{0, 0, 0}; });
  Expect(invalid, ".derivative_v", [nan](auto& c) { c.derivative_v = Vec3{nan, 0, 0}; });
  Expect(invalid, ".derivative_v", [](auto& c) {
    c.normal.reset();
    c.derivative_u = Vec3{1, 0, 0};
    c.derivative_v = Vec3{-2, 0, 0};
  });
  Expect(invalid, ".normal", [](auto& c) { c.derivative_u = Vec3{1, 0, 0.5}; });
  Expect(invalid, ".derivative_u", [&](auto& c) {
    at_vertex(c, 3);
    c.derivative_u = Vec3{1, 0, 0};
  });
  Expect(invalid, ".point", [&](auto& c) {
    at_vertex(c, 3);
    c.point = {0.5, 0.5, 0.5};
  });
  // A parameter at an interpolated vertex is no way around that.
  Expect(invalid, ".point", [&](auto& c) {
    c.parameter = SurfaceParameter{5, 1, 0, 0};
    c.point = {0.5, 0.5, 0.5};
  });
  Expect(invalid, ".parameter", [&](auto& c) {
    const PolygonMesh cube = oracle::Cube();
    for (Index f = 0; f < 6; ++f) {
      for (Index i = 0; i < 4; ++i) {
        if (cube.corner_vertex[4 * f + i] == 0) c.parameter = SurfaceParameter{f, i, 0, 0};
      }
    }
  });
  for (const double far : {1e6, 1e12, 1e308}) {
    Expect(invalid, ".point", [far](auto& c) { c.point = {far, 0, 0}; });
    for (const double length : {far, 1 / far}) {
      Expect(invalid, ".derivative_u", [length](auto& c) {
        c.normal.reset();
        c.derivative_u = Vec3{length, 0, 0};
      });
    }
  }
  Expect(range, ".region[1]", [](auto& c) { c.region = {0, 96}; });
  Expect(invalid, ".region", [](auto& c) { c.region = {95}; });
  ExpectError(StatusOf(
                  [](auto& c) {
                    c.parameter = SurfaceParameter{5, 1, 0.7, 0.4};
                  },
                  Scheme::kLoop),
              {invalid, "constraints.surface_points[1].parameter.v", 1});
  ExpectError(StatusOf([](auto&) {}, Scheme::kDooSabin), {invalid, "constraints.surface_points"});
}

// A hub with constraints all around it.
TEST_F(BlendErrors, RegionsAreBounded) {
  InterpolateOptions options = {.scheme = Scheme::kCatmullClark, .level = 0};
  options.constraints.interpolate.emplace();
  const PolygonMesh hub = oracle::DoublePyramid(3000);
  for (Index f = 0; f < 3000; ++f) {
    options.constraints.surface_points.push_back(
        {.parameter = SurfaceParameter{f, 0, 0.5, 0.5}, .point = Vec3{0, 0, 1}});
  }
  ExpectError(Interpolate(Context(), hub, options).status(),
              {Reason::kLimitExceeded, "constraints"});
}

TEST_F(BlendErrors, HolesAreNoPartOfTheSurface) {
  InterpolateOptions options = {.scheme = Scheme::kCatmullClark, .level = 0};
  options.constraints.holes = {3};
  options.constraints.surface_points = {
      {.parameter = SurfaceParameter{3, 0, 0.5, 0.5}, .normal = Vec3{0, 0, 1}}};
  ExpectError(Interpolate(Context(), oracle::Cube(), options).status(),
              {Reason::kInvalidOption, "constraints.surface_points[0].parameter.face", 0});
}

// However many: neither time nor memory grows with their square.
TEST_F(BlendErrors, TooManyTogetherAreRefused) {
  InterpolateOptions options = {.scheme = Scheme::kCatmullClark, .level = 0};
  for (int i = 0; i < 20'000; ++i) {
    options.constraints.surface_points.push_back(
        {.parameter = SurfaceParameter{0, 0, 0.00005 * i, 0.5}, .normal = Vec3{0, 0, 1}});
  }
  ExpectError(Interpolate(Context(), oracle::Cube(), options).status(),
              {Reason::kLimitExceeded, "constraints.surface_points[0]", 0});
}

}  // namespace
}  // namespace limn
