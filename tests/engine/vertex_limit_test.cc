// SPDX-License-Identifier: MIT
// Limits of Catmull-Clark and Loop surfaces at vertices, held against deep refinement.
#include "engine/limit/vertex_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/mesh/generate.h"
#include "tests/oracle/creased_level.h"
#include "tests/oracle/deep_limit.h"

namespace limn {
namespace {

using oracle::CreasedLevel;
using oracle::CreasedMesh;
using oracle::Creases;
using oracle::DeepLimit;
using oracle::Point;
using oracle::Rule;

absl::Status FindLimits(const Context& context, const CreasedLevel& level,
                        const VertexLimits& limits) {
  return level.rule == Rule::kLoop
             ? LoopLimits(context, level.level(), level.points, limits)
             : CatmullClarkLimits(context, level.level(), level.points, limits);
}

struct Limits {
  std::vector<Vec3> points;
  std::vector<Tangents> tangents;
  std::vector<Vec3> normals;
};
Limits LimitsOf(const CreasedLevel& level) {
  Limits limits;
  limits.points.resize(level.points.size());
  limits.tangents.resize(level.points.size());
  limits.normals.resize(level.points.size());
  EXPECT_TRUE(FindLimits(Context(), level,
                         {absl::MakeSpan(limits.points), absl::MakeSpan(limits.tangents),
                          absl::MakeSpan(limits.normals)})
                  .ok());
  return limits;
}

// Creases, corners and crossings that never wear off.
Creases LastingCreases(const PolygonMesh& mesh, std::uint64_t seed) {
  Creases creases = oracle::RandomCreases(mesh, seed);
  for (float& sharpness : creases.sharpnesses) sharpness = kSharpForever;
  for (float& sharpness : creases.corner_sharpnesses) sharpness = kSharpForever;
  return creases;
}

Point ToPoint(const Vec3& v) { return {v.x, v.y, v.z}; }

// The limits by many refinements: until the least eigenvalue in play is below rounding.
constexpr int kDeep = 70;

// Until what shrinks by 1/2 is lost beside what shrinks by 0.5518, the second of four triangles.
constexpr int kDeepCorner = 160;

// What the ring of a vertex makes of normals by refinement.
struct Expectation {
  // Refinements that serve it best, and the difference of normals that they leave.
  int steps = kDeep;
  double tolerance = 1e-5;
  // Whether u x v is the normal: one surface only.
  bool one_surface = true;
  // Whether planes tend to one at all, faster than 1 / steps.
  bool settles = true;
};

bool IsSlowCorner(const DeepLimit& deep, Rule rule) {
  const std::size_t n = deep.ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t f = 1;
    while (f < n && !deep.sharp[(i + f) % n]) ++f;
    if (deep.sharp[i] && (f == 2 || (f == 3 && rule == Rule::kLoop))) return true;
  }
  return false;
}

Expectation ExpectationFor(const DeepLimit& deep, Rule rule, bool corner) {
  const std::size_t n = deep.ring.size();
  const auto sharp =
      static_cast<std::size_t>(std::count(deep.sharp.begin(), deep.sharp.end(), true));
  const bool crease = !corner && sharp == 2;
  Expectation expected;
  expected.one_surface = sharp < 2 || (crease && !deep.closed);
  // Waves of high valence differ little: the third shrinks hardly faster than the second.
  if (n >= 8) expected.tolerance = 1e-3;
  if (n >= 12) expected.tolerance = 0.1;
  if (n >= 40) expected.tolerance = 0.5;
  bool one_face = false;
  for (std::size_t i = 0; i < n; ++i) {
    one_face = one_face || (deep.sharp[i] && deep.sharp[(i + 1) % n] && (deep.closed || n == 2));
  }
  if (crease && one_face) {
    // The bend of the curve shrinks twice as fast as its tangent, and is lost in rounding soon.
    expected.steps = 24;
    expected.tolerance = n <= 3 ? 1e-6 : (n == 4 ? 1e-2 : 0.2);
  }
  // What is left beside a cusp's direction soon is too small to see.
  if (corner && sharp == 0) {
    expected.steps = 10;
    expected.tolerance = n <= 4 ? 1e-2 : 0.5;
    return expected;
  }
  if (corner || sharp > 2) {
    expected.steps = kDeepCorner;
    // Two or three triangles, two quads: ring_limit_test.cc has them in closed form.
    expected.settles = !IsSlowCorner(deep, rule);
  }
  return expected;
}

class VertexLimitTest : public testing::TestWithParam<std::tuple<Rule, std::string>> {
 protected:
  static Rule rule() { return std::get<0>(GetParam()); }
  static PolygonMesh Given() {
    const PolygonMesh mesh = oracle::MeshFor(rule(), std::get<1>(GetParam()));
    // Symmetric meshes would hide mistakes.
    return oracle::Jittered(mesh, 17, 0.05);
  }
  static std::vector<Creases> Variants(const PolygonMesh& mesh) {
    Creases creased = LastingCreases(mesh, 1);
    Creases smooth_corners = LastingCreases(mesh, 2);
    smooth_corners.boundary = BoundaryRule::kEdgeOnly;
    return {{}, {.boundary = BoundaryRule::kEdgeOnly}, creased, smooth_corners};
  }
};

void ExpectDeepLimits(const CreasedLevel& level, const CreasedMesh& expected) {
  const Limits limits = LimitsOf(level);
  const oracle::Real diagonal = oracle::Diagonal(expected.points);
  const std::size_t stride = 1 + expected.points.size() / 10;
  for (std::size_t v = 0; v < expected.points.size(); v += stride) {
    SCOPED_TRACE(v);
    const int number = static_cast<int>(v);
    const DeepLimit deep = oracle::RefineDeeply(expected, level.rule, number, kDeep);
    ASSERT_LE(oracle::Norm(ToPoint(limits.points[v]) - deep.point), 1e-13 * diagonal);
    const Expectation expectation =
        ExpectationFor(deep, level.rule, expected.vertex_sharpness[v] > 0);
    const Vec3 normal = limits.normals[v];
    if (normal == Vec3{0, 0, 0}) continue;
    ASSERT_NEAR(Norm(normal), 1, 1e-14);
    if (!expectation.settles) continue;
    const Point deep_normal =
        expectation.steps == kDeep
            ? deep.normal
            : oracle::RefineDeeply(expected, level.rule, number, expectation.steps).normal;
    ASSERT_LE(oracle::Norm(ToPoint(normal) - deep_normal), expectation.tolerance)
        << deep.ring.size() << " edges, sharp "
        << std::count(deep.sharp.begin(), deep.sharp.end(), true) << ", corner "
        << expected.vertex_sharpness[v] << ", closed " << deep.closed;
    if (!expectation.one_surface) continue;
    const Tangents& t = limits.tangents[v];
    ASSERT_LE(Norm(NormalizedOrZero(Cross(t.u, t.v)) - normal), 1e-12);
  }
}

TEST_P(VertexLimitTest, AreThoseOfDeepRefinement) {
  const PolygonMesh given = Given();
  for (const Creases& creases : Variants(given)) {
    CreasedLevel level(given, rule(), creases);
    CreasedMesh expected = oracle::WithCreases(oracle::FromPolygonMesh(given), creases);
    ExpectDeepLimits(level, expected);
    level.Refine();
    expected = oracle::RefineCreased(expected, rule());
    if (expected.points.size() < 400) ExpectDeepLimits(level, expected);
  }
}

// Left eigenvectors: refinement keeps limit points and normals, and scales tangents.
TEST_P(VertexLimitTest, RefinementKeepsPointsAndScalesTangents) {
  const PolygonMesh given = Given();
  const double diagonal = static_cast<double>(oracle::Diagonal(oracle::FromVec3(given.positions)));
  for (const Creases& creases : Variants(given)) {
    CreasedLevel level(given, rule(), creases);
    const Limits first = LimitsOf(level);
    level.Refine();
    const Limits second = LimitsOf(level);
    level.Refine();
    const Limits third = LimitsOf(level);
    for (std::size_t v = 0; v < first.points.size(); ++v) {
      SCOPED_TRACE(v);
      ASSERT_LE(Norm(second.points[v] - first.points[v]), 2e-15 * diagonal);
      ASSERT_LE(Norm(third.points[v] - second.points[v]), 2e-15 * diagonal);
      // Slow corners: see the header.
      ASSERT_LE(Norm(third.normals[v] - second.normals[v]), level.IsCorner(v) ? 0.5 : 1e-8);
      const auto expect_scaled = [&](const Vec3& before, const Vec3& after) {
        const double ratio = Dot(after, before) / Dot(before, before);
        ASSERT_LE(Norm(after - ratio * before), 1e-13 * diagonal);
        // Between that of a single face's bend and that of a flat cone of many faces.
        ASSERT_GE(ratio, 0.1);
        ASSERT_LE(ratio, 0.66);
      };
      if (Norm(second.tangents[v].u) > 1e-3 * diagonal) {
        expect_scaled(second.tangents[v].u, third.tangents[v].u);
      }
      // The other vertex of a lone quad on a straight boundary is no eigenvector.
      if (Norm(second.tangents[v].v) > 1e-3 * diagonal) {
        expect_scaled(second.tangents[v].v, third.tangents[v].v);
      }
    }
  }
}

TEST_P(VertexLimitTest, PointsDoNotDependOnWhatElseIsAskedFor) {
  const PolygonMesh given = Given();
  CreasedLevel level(given, rule(), LastingCreases(given, 3));
  for (int k = 0; k < 2; ++k) {
    const Limits all = LimitsOf(level);
    std::vector<Vec3> points(level.points.size());
    std::vector<Vec3> normals(level.points.size());
    ASSERT_TRUE(FindLimits(Context(), level, {absl::MakeSpan(points), {}, {}}).ok());
    EXPECT_EQ(points, all.points);
    // The first vertices only.
    const std::size_t n = points.size() / 2;
    ASSERT_TRUE(FindLimits(Context(), level,
                           {absl::MakeSpan(points).first(n), {}, absl::MakeSpan(normals).first(n)})
                    .ok());
    EXPECT_EQ(points, all.points);
    EXPECT_TRUE(std::equal(normals.begin(), normals.begin() + static_cast<std::ptrdiff_t>(n),
                           all.normals.begin()));
    level.Refine();
  }
}

// All that lies in a plane has its normal.
TEST_P(VertexLimitTest, PlanarMeshesHaveThePlanesNormal) {
  PolygonMesh given = Given();
  const Vec3 up = {2.0 / 7, 3.0 / 7, 6.0 / 7};
  for (Vec3& p : given.positions) p = p - Dot(p, up) * up + 5.0 * up;
  CreasedLevel level(given, rule(), LastingCreases(given, 4));
  level.Refine();
  const Limits limits = LimitsOf(level);
  for (std::size_t v = 0; v < limits.points.size(); ++v) {
    EXPECT_NEAR(Dot(limits.points[v], up), 5, 1e-14);
    EXPECT_LE(std::fabs(Dot(limits.tangents[v].u, up)), 1e-13);
    EXPECT_LE(std::fabs(Dot(limits.tangents[v].v, up)), 1e-13);
    EXPECT_LE(Norm(Cross(limits.normals[v], up)), 1e-7);
  }
}

std::string NameOf(const testing::TestParamInfo<std::tuple<Rule, std::string>>& info) {
  return (std::get<0>(info.param) == Rule::kLoop ? "Loop_" : "CatmullClark_") +
         std::get<1>(info.param);
}
INSTANTIATE_TEST_SUITE_P(All, VertexLimitTest,
                         testing::Combine(testing::Values(Rule::kCatmullClark, Rule::kLoop),
                                          testing::ValuesIn(oracle::AllMeshNames())),
                         NameOf);

// The row of the design for faces of any arity: V (n - 1) / (n + 5) + ...
TEST(VertexLimit, TheFirstRefinementFoldsIntoOneRow) {
  for (const std::string& name : oracle::ClosedMeshNames()) {
    SCOPED_TRACE(name);
    const PolygonMesh given = oracle::ClosedMesh(name);
    const CreasedLevel level(given, Rule::kCatmullClark, {});
    const Limits limits = LimitsOf(level);
    const PolygonWalk walk(level.mesh);
    for (std::size_t v = 0; v < given.vertex_count(); ++v) {
      const double n = static_cast<double>(level.mesh.valence(v));
      Vec3 sum = (n - 1) / (n + 5) * given.positions[v];
      for (Index i = level.mesh.fan_begin()[v]; i < level.mesh.fan_begin()[v + 1]; ++i) {
        const Index h = level.mesh.fan()[i];
        sum += 2 / (n * (n + 5)) * given.positions[level.mesh.vertex()[walk.Next(h)]];
        const auto face = given.face(level.mesh.face()[h]);
        for (const Index u : face) {
          sum += 4 / (n * (n + 5)) / static_cast<double>(face.size()) * given.positions[u];
        }
      }
      ASSERT_LE(MaxAbs(limits.points[v] - sum), 1e-14);
    }
  }
}

TEST(VertexLimit, RegularVerticesHaveTheDerivativesOfSplines) {
  CreasedLevel level(oracle::Jittered(oracle::TorusOfQuads(6, 5), 3, 0.2), Rule::kCatmullClark, {});
  level.Refine();
  const Limits limits = LimitsOf(level);
  const QuadWalk walk(level.mesh);
  for (std::size_t v = 0; v < 30; ++v) {
    const Index h = level.mesh.vertex_half_edge()[v];
    const auto at = [&](Index i) { return level.points[level.mesh.vertex()[i]]; };
    const Index b = RotateCcw(walk, level.mesh.twin(), h);
    const Index c = RotateCcw(walk, level.mesh.twin(), b);
    const Index d = RotateCcw(walk, level.mesh.twin(), c);
    const auto end = [&](Index i) { return at(walk.Next(i)); };
    const auto across = [&](Index i) { return at(walk.Next(walk.Next(i))); };
    // (-1 0 1) / 2 times (1 4 1) / 6.
    const Vec3 u =
        (1 / 12.0) * (4 * (end(h) - end(c)) + across(h) + across(d) - across(b) - across(c));
    EXPECT_LE(MaxAbs(limits.tangents[v].u - u), 1e-15);
  }
}

TEST_P(VertexLimitTest, WhatWearsOffIsRefinedAwayFirst) {
  const PolygonMesh given = Given();
  const double diagonal = static_cast<double>(oracle::Diagonal(oracle::FromVec3(given.positions)));
  const Creases creases = oracle::RandomCreases(given, 2);
  CreasedLevel level(given, rule(), creases);
  const Limits limits = LimitsOf(level);
  for (int k = 0; k < 3; ++k) level.Refine();
  ASSERT_EQ(level.sharpness.transient, 0);
  const Limits settled = LimitsOf(level);
  std::vector<int> sharp_edges(level.mesh.vertex_count());
  for (std::size_t h = 0; h < level.mesh.half_edge_count(); ++h) {
    const Index edge = level.mesh.edge()[h];
    if (!level.sharpness.creased() || level.sharpness.edge[edge] == 0) continue;
    ++sharp_edges[level.mesh.vertex()[h]];
    // The half-edge that would leave the other end along the boundary is not there.
    const auto next =
        static_cast<Index>(rule() == Rule::kLoop ? TriangleWalk::Next(static_cast<Index>(h))
                                                 : QuadWalk::Next(static_cast<Index>(h)));
    if (level.mesh.twin()[h] == kNoIndex) ++sharp_edges[level.mesh.vertex()[next]];
  }
  for (std::size_t v = 0; v < given.vertex_count(); ++v) {
    ASSERT_LE(Norm(limits.points[v] - settled.points[v]), 1e-14 * diagonal) << v;
    // Corners have normals of their level only, see the header.
    const bool corner =
        sharp_edges[v] > 2 || (level.sharpness.creased() && level.sharpness.vertex[v] > 0);
    if (corner || !level.sharpness.creased()) continue;
    ASSERT_LE(Norm(limits.normals[v] - settled.normals[v]), 1e-9) << v;
  }
}

TEST(VertexLimit, NormalsDoNotDependOnPlaceAndSize) {
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    const PolygonMesh given = oracle::MeshFor(rule, "prism_7_jittered_seed_4");
    const Creases creases = LastingCreases(given, 1);
    const Limits expected = LimitsOf(CreasedLevel(given, rule, creases));
    for (const double size : {1e-150, 1e-50, 1e50, 1e90}) {
      const Limits limits = LimitsOf(CreasedLevel(oracle::Moved(given, size, {}), rule, creases));
      for (std::size_t v = 0; v < limits.points.size(); ++v) {
        ASSERT_LE(MaxAbs(limits.points[v] - size * expected.points[v]), 1e-14 * size);
        ASSERT_LE(MaxAbs(limits.normals[v] - expected.normals[v]), 1e-12);
      }
    }
    const Limits far =
        LimitsOf(CreasedLevel(oracle::Moved(given, 1, {1e4, -2e4, 3e4}), rule, creases));
    for (std::size_t v = 0; v < far.points.size(); ++v) {
      ASSERT_LE(MaxAbs(far.normals[v] - expected.normals[v]), 1e-9);
    }
  }
}

TEST(VertexLimit, HasTheSameBitsForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh disk,
                            GenerateMesh({.kind = MeshKind::kDisk, .vertices = 10000, .seed = 3}));
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    const PolygonMesh given = rule == Rule::kLoop ? oracle::Triangulated(disk) : disk;
    CreasedLevel level(given, rule, LastingCreases(given, 5));
    for (int k = 0; k < 2; ++k) {
      const auto find = [&](int threads) {
        return oracle::WithThreads(threads, [&] { return LimitsOf(level); });
      };
      const Limits one = find(1);
      for (const int threads : {2, 5}) {
        const Limits many = find(threads);
        EXPECT_EQ(one.points, many.points);
        EXPECT_EQ(one.normals, many.normals);
      }
      level.Refine();
    }
  }
}

TEST(VertexLimit, RefusesWhatDoesNotFit) {
  const CreasedLevel quads(oracle::Cube(), Rule::kCatmullClark, {});
  CreasedLevel triangles(oracle::Octahedron(), Rule::kLoop, {});
  std::vector<Vec3> room(9);
  std::vector<Tangents> tangents(9);
  const auto span = absl::MakeSpan(room);
  const auto refused = [&](const CreasedLevel& level, const VertexLimits& limits) {
    oracle::ExpectError(FindLimits(Context(), level, limits), {Reason::kInternal});
  };
  EXPECT_TRUE(FindLimits(Context(), quads, {span.first(8), {}, span.first(8)}).ok());
  refused(quads, {span, {}, {}});
  refused(quads, {span.first(8), {}, span.first(7)});
  refused(quads, {span.first(8), absl::MakeSpan(tangents), {}});
  refused(triangles, {span, {}, {}});
  oracle::ExpectError(LoopLimits(Context(), quads.level(), quads.points, {span.first(8), {}, {}}),
                      {Reason::kInvalidOption, "mesh.faces", 0});
  triangles.Refine();
  oracle::ExpectError(
      CatmullClarkLimits(Context(), triangles.level(), triangles.points, {span.first(6), {}, {}}),
      {Reason::kInternal});
}

TEST(VertexLimit, EndsWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  std::vector<Vec3> room(6);
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    CreasedLevel level(oracle::Octahedron(), rule, {});
    for (int k = 0; k < 2; ++k) {
      oracle::ExpectError(FindLimits(cancelled, level, {absl::MakeSpan(room), {}, {}}),
                          {Reason::kCancelled});
      level.Refine();
    }
  }
}

}  // namespace
}  // namespace limn
