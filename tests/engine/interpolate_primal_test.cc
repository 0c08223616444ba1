// SPDX-License-Identifier: MIT
// The guarantees of the whole job for Catmull-Clark and Loop surfaces. The oracle refines the
// control mesh that comes back, by the textbook, until it does not move any more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/creased_level.h"
#include "tests/oracle/deep_limit.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::CreasedMesh;
using oracle::Creases;
using oracle::Real;
using oracle::Rule;

Scheme SchemeOf(Rule rule) { return rule == Rule::kLoop ? Scheme::kLoop : Scheme::kCatmullClark; }

// The oracle's creases as constraints.
Constraints ConstraintsOf(const Creases& creases) {
  Constraints constraints;
  std::size_t at = 0;
  std::size_t edge = 0;
  const bool per_crease = creases.sharpnesses.size() == creases.lengths.size();
  for (std::size_t c = 0; c < creases.lengths.size(); ++c) {
    CreaseConstraint& crease = constraints.creases.emplace_back();
    for (Index i = 0; i < creases.lengths[c]; ++i) {
      crease.vertices.push_back(creases.indices[at++]);
      if (!per_crease && i > 0) crease.sharpness.push_back(creases.sharpnesses[edge++]);
    }
    if (per_crease) crease.sharpness.push_back(creases.sharpnesses[c]);
  }
  for (std::size_t i = 0; i < creases.corners.size(); ++i) {
    constraints.corners.push_back({creases.corners[i], creases.corner_sharpnesses[i]});
  }
  constraints.holes = creases.holes;
  return constraints;
}

Real Size(const PolygonMesh& mesh) {
  const Real diagonal = oracle::Diagonal(oracle::FromVec3(mesh.positions));
  return diagonal > 0 ? diagonal : 1;
}

// The oracle's surface of a control mesh: its T^1, where all faces are the scheme's own.
CreasedMesh RefinedOnce(const PolygonMesh& mesh, const InterpolateResult& result, Rule rule,
                        const Creases& creases) {
  PolygonMesh control = mesh;
  control.positions.assign(result.control_positions.begin(), result.control_positions.end());
  return oracle::RefineCreased(oracle::WithCreases(oracle::FromPolygonMesh(control), creases), rule,
                               result.bilinear_share);
}

// Largest distance of the oracle's limit points from the given ones, at some vertices.
Real OracleError(const PolygonMesh& mesh, const CreasedMesh& refined, Rule rule,
                 const std::vector<Index>& vertices) {
  Real most = 0;
  for (const Index v : vertices) {
    const auto limit = oracle::RefineDeeply(refined, rule, static_cast<int>(v), 50);
    const auto given = oracle::FromVec3({&mesh.positions[v], 1}).front();
    const oracle::Point d = limit.point - given;
    most = std::max(most, std::sqrt(oracle::Dot(d, d)));
  }
  return most;
}

std::vector<Index> SomeVertices(const PolygonMesh& mesh, const Creases& creases) {
  std::vector<Index> some(creases.indices.begin(), creases.indices.end());
  some.insert(some.end(), creases.corners.begin(), creases.corners.end());
  const auto n = static_cast<Index>(mesh.vertex_count());
  for (Index i = 0; i < 4; ++i) some.push_back(i * (n - 1) / 3);
  std::sort(some.begin(), some.end());
  some.erase(std::unique(some.begin(), some.end()), some.end());
  if (some.size() > 8) {
    std::mt19937_64 random(7);
    std::shuffle(some.begin(), some.end(), random);
    some.resize(8);
  }
  return some;
}

class PrimalTest : public testing::TestWithParam<std::tuple<Rule, std::string>> {
 protected:
  PrimalTest() : mesh_(oracle::MeshFor(rule(), std::get<1>(GetParam()))) {
    options_.scheme = SchemeOf(rule());
    options_.level = 1;
  }
  static Rule rule() { return std::get<0>(GetParam()); }

  InterpolateResult Run() const {
    auto result = Interpolate(Context(), mesh_, options_);
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() ? *std::move(result) : InterpolateResult{};
  }

  // What the result says is so, and the oracle's surface passes through the points.
  void ExpectInterpolates(const InterpolateResult& result, const Creases& creases) const {
    const Real size = Size(mesh_);
    EXPECT_TRUE(result.solve.converged) << result.solve.residual;
    EXPECT_LE(result.solve.residual, 1e-12);
    // The tolerance, and the rounding of the limit points.
    for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
      ASSERT_LE(Norm(result.surface.positions[v] - mesh_.positions[v]), 1.01e-12 * size) << v;
    }
    EXPECT_LE(OracleError(mesh_, RefinedOnce(mesh_, result, rule(), creases), rule(),
                          SomeVertices(mesh_, creases)),
              1e-11 * size);
  }

  PolygonMesh mesh_;
  InterpolateOptions options_;
};

TEST_P(PrimalTest, TheSurfacePassesThroughThePoints) { ExpectInterpolates(Run(), {}); }

TEST_P(PrimalTest, TheSurfacePassesThroughThePointsWhereItIsSharp) {
  for (const std::uint64_t seed : {1U, 2U}) {
    SCOPED_TRACE(seed);
    Creases creases = oracle::RandomCreases(mesh_, seed);
    options_.constraints = ConstraintsOf(creases);
    ExpectInterpolates(Run(), creases);
  }
}

TEST_P(PrimalTest, BoundaryRulesHold) {
  for (const BoundaryRule boundary : {BoundaryRule::kNone, BoundaryRule::kEdgeOnly}) {
    Creases creases;
    creases.boundary = boundary;
    options_.boundary = boundary;
    ExpectInterpolates(Run(), creases);
  }
}

TEST_P(PrimalTest, SubsetsLeaveTheOthersAsControlPoints) {
  std::mt19937_64 random(3);
  options_.constraints.interpolate.emplace();
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    if (random() % 2 == 0) options_.constraints.interpolate->push_back(v);
  }
  const InterpolateResult result = Run();
  EXPECT_TRUE(result.solve.converged);
  const auto& subset = *options_.constraints.interpolate;
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    if (std::find(subset.begin(), subset.end(), v) != subset.end()) {
      ASSERT_LE(MaxAbs(result.surface.positions[v] - mesh_.positions[v]), 4e-12 * Size(mesh_)) << v;
    } else {
      ASSERT_EQ(result.control_positions[v], mesh_.positions[v]) << v;
    }
  }
}

// The oracle numbers its refinements as the contract says. Holes are left out.
TEST_P(PrimalTest, TessellationsAreNumberedByTheContractAndHavePointsOfTheLimit) {
  const Creases creases = oracle::RandomCreases(mesh_, 5);
  options_.constraints = ConstraintsOf(creases);
  for (const std::uint32_t level : {1U, 2U}) {
    options_.level = level;
    const InterpolateResult result = Run();
    CreasedMesh refined = RefinedOnce(mesh_, result, rule(), creases);
    for (std::uint32_t k = 1; k < level; ++k) refined = oracle::RefineCreased(refined, rule());
    ASSERT_EQ(result.surface.vertex_count(), refined.points.size());
    std::size_t face = 0;
    const std::size_t arity = rule() == Rule::kLoop ? 3 : 4;
    ASSERT_EQ(result.surface.arity, arity);
    for (std::size_t f = 0; f < refined.faces.size(); ++f) {
      if (refined.hole[f]) continue;
      for (std::size_t i = 0; i < arity; ++i) {
        ASSERT_EQ(result.surface.face_vertices[face * arity + i],
                  static_cast<Index>(refined.faces[f][i]));
      }
      ++face;
    }
    EXPECT_EQ(result.surface.face_count(), face);
    // New vertices, too, are on the surface.
    for (std::size_t v = mesh_.vertex_count(); v < refined.points.size();
         v += 1 + refined.points.size() / 5) {
      const auto limit = oracle::RefineDeeply(refined, rule(), static_cast<int>(v), 50);
      const oracle::Point d =
          limit.point - oracle::FromVec3({&result.surface.positions[v], 1}).front();
      EXPECT_LE(std::sqrt(oracle::Dot(d, d)), 1e-11 * Size(mesh_)) << v;
    }
  }
}

TEST_P(PrimalTest, LevelZeroHasTheGivenFacesButHolesAndTheSamePointsAndNormals) {
  const Creases creases = oracle::RandomCreases(mesh_, 6);
  options_.constraints = ConstraintsOf(creases);
  const InterpolateResult fine = Run();
  options_.level = 0;
  const InterpolateResult coarse = Run();
  ASSERT_EQ(coarse.surface.vertex_count(), mesh_.vertex_count());
  EXPECT_EQ(coarse.surface.face_count(), mesh_.face_count() - creases.holes.size());
  for (std::size_t v = 0; v < mesh_.vertex_count(); ++v) {
    ASSERT_LE(MaxAbs(coarse.surface.positions[v] - fine.surface.positions[v]), 1e-13 * Size(mesh_));
    ASSERT_LE(MaxAbs(coarse.surface.normals[v] - fine.surface.normals[v]), 1e-6) << v;
  }
}

TEST_P(PrimalTest, SameBitsForAnyNumberOfThreads) {
  options_.constraints = ConstraintsOf(oracle::RandomCreases(mesh_, 8));
  options_.level = 2;
  const InterpolateResult one = oracle::WithThreads(1, [&] { return Run(); });
  const InterpolateResult three = oracle::WithThreads(3, [&] { return Run(); });
  EXPECT_TRUE(one.control_positions == three.control_positions);
  EXPECT_TRUE(one.surface.positions == three.surface.positions);
  EXPECT_TRUE(one.surface.normals == three.surface.normals);
  EXPECT_TRUE(one.surface.face_vertices == three.surface.face_vertices);
}

// Far from the origin the job runs around the middle of the model.
TEST_P(PrimalTest, FarFromTheOriginTheSurfaceIsTheSame) {
  const InterpolateResult near = Run();
  const Vec3 shift = {1e6 * static_cast<double>(Size(mesh_)), 0, 0};
  for (Vec3& p : mesh_.positions) p += shift;
  const InterpolateResult far = Run();
  for (std::size_t v = 0; v < near.surface.vertex_count(); ++v) {
    ASSERT_LE(MaxAbs(far.surface.positions[v] - shift - near.surface.positions[v]),
              1e-8 * Size(mesh_));
  }
}

std::string NameOf(const testing::TestParamInfo<std::tuple<Rule, std::string>>& info) {
  return (std::get<0>(info.param) == Rule::kLoop ? "Loop_" : "CatmullClark_") +
         std::get<1>(info.param);
}
INSTANTIATE_TEST_SUITE_P(Meshes, PrimalTest,
                         testing::Combine(testing::Values(Rule::kCatmullClark, Rule::kLoop),
                                          testing::ValuesIn(oracle::AllMeshNames())),
                         NameOf);

class CatmullClarkRuleTest : public testing::Test {
 protected:
  static absl::StatusOr<InterpolateResult> Run(const std::string& name,
                                               InterpolateOptions options = {}) {
    options.scheme = Scheme::kCatmullClark;
    options.level = 1;
    return Interpolate(Context(), oracle::ClosedMesh(name), options);
  }
};

TEST_F(CatmullClarkRuleTest, SingularMeshesGetAShareOfTheBilinearRule) {
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Run("cube"));
  EXPECT_EQ(result.rule, FirstRule::kBilinear);
  EXPECT_EQ(result.bilinear_share, 0.5);
  EXPECT_TRUE(result.solve.converged);
}

TEST_F(CatmullClarkRuleTest, StrictRefusesThem) {
  oracle::ExpectError(Run("cube", {.strict = true}).status(),
                      {Reason::kIllConditioned, "solve.strict"});
}

TEST_F(CatmullClarkRuleTest, ARuleThatIsNamedIsKept) {
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult bilinear,
                            Run("torus_of_quads", {.rule = FirstRule::kBilinear}));
  EXPECT_EQ(bilinear.bilinear_share, 1);
  EXPECT_TRUE(bilinear.solve.converged);
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult standard,
                            Run("cube", {.rule = FirstRule::kStandard}));
  EXPECT_EQ(standard.rule, FirstRule::kStandard);
}

TEST_F(CatmullClarkRuleTest, RegularMeshesKeepTheSchemesOwnRule) {
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result,
                            Run("torus_of_quads", {.strict = true}));
  EXPECT_EQ(result.rule, FirstRule::kStandard);
  EXPECT_EQ(result.bilinear_share, 0);
}

// Nothing is known of the equations yet: the rule stays the scheme's own.
TEST_F(CatmullClarkRuleTest, RunningOutOfSweepsDoesNotChangeTheRule) {
  for (const char* const name : {"torus_of_quads", "antiprism_40"}) {
    const PolygonMesh mesh = oracle::ClosedMesh(name);
    const CreaseConstraint crease = {{mesh.corner_vertex[0], mesh.corner_vertex[1]}, {2.5F}};
    for (const bool creased : {false, true}) {
      for (const SolveOptions& solve :
           {SolveOptions{.tolerance = 0, .max_sweeps = 60}, {.max_sweeps = 1}, {.max_sweeps = 3}}) {
        SCOPED_TRACE(absl::StrCat(name, ", creased ", creased, ", sweeps ", solve.max_sweeps));
        InterpolateOptions options = {.strict = true, .solve = solve};
        if (creased) options.constraints.creases = {crease};
        LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Run(name, options));
        EXPECT_EQ(result.rule, FirstRule::kStandard);
        EXPECT_LE(result.solve.sweeps, solve.max_sweeps);
      }
    }
  }
}

// Chebyshev, where its bound is proved, series and conjugate gradients.
TEST_F(CatmullClarkRuleTest, EveryMethodGivesOneSurface) {
  for (const std::string name : {"octahedron", "dodecahedron", "ngons_seed_1", "torus_of_quads"}) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = oracle::ClosedMesh(name);
    LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult automatic, Run(name));
    for (const SolveMethod method :
         {SolveMethod::kSeries, SolveMethod::kConjugateGradient, SolveMethod::kChebyshev}) {
      LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult by,
                                Run(name, {.solve = {.method = method, .max_sweeps = 2000}}));
      EXPECT_EQ(by.solve.method, method);
      EXPECT_TRUE(by.solve.converged);
      EXPECT_EQ(by.rule, automatic.rule);
      EXPECT_EQ(by.bilinear_share, automatic.bilinear_share);
      // Residuals of 1e-12, at the worst 32 times as much in the solutions, from both sides.
      const Real near = 64e-12L * Size(mesh);
      EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(by.control_positions),
                                    oracle::FromVec3(automatic.control_positions)),
                near);
      EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(by.surface.positions),
                                    oracle::FromVec3(automatic.surface.positions)),
                near);
    }
  }
}

// Neither the points nor how, where and how far they are solved for.
TEST(CatmullClarkRule, FollowsTheFacesAlone) {
  const auto share = [](const PolygonMesh& mesh, const SolveOptions& solve) {
    const auto result = Interpolate(
        Context(), mesh, {.scheme = Scheme::kCatmullClark, .solve = solve, .surface = false});
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() ? result->bilinear_share : -1;
  };
  const auto expect = [&](const PolygonMesh& mesh, double expected) {
    const double size = static_cast<double>(Size(mesh));
    for (const double shift : {0.0, 30.0, 1e6}) {
      const PolygonMesh moved = oracle::Moved(mesh, 1, {shift * size, 0, 0});
      for (const double tolerance : {0.0, 1e-14, 1e-12, 1e-6, 1e-3}) {
        for (const std::uint32_t sweeps : {0U, 1U, 5U, 20U, 100U}) {
          SCOPED_TRACE(absl::StrCat("shift ", shift, ", ", tolerance, ", sweeps ", sweeps));
          const SolveOptions solve = {.tolerance = tolerance, .max_sweeps = sweeps};
          ASSERT_EQ(share(moved, solve), expected);
        }
      }
    }
    for (const SolveMethod method : {SolveMethod::kSeries, SolveMethod::kConjugateGradient}) {
      ASSERT_EQ(share(mesh, {.method = method}), expected);
    }
    ASSERT_EQ(share(oracle::Jittered(mesh, 3, 0.4 * size), {}), expected);
  };
  for (const std::uint64_t seed : {1U, 2U}) {
    SCOPED_TRACE(absl::StrCat("seed: ", seed));
    LIMN_ASSERT_OK_AND_ASSIGN(
        const PolygonMesh ngons,
        GenerateMesh({.kind = MeshKind::kNgons, .vertices = 562, .seed = seed}));
    expect(ngons, 0.5);
    LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh sphere,
                              GenerateMesh({.vertices = 562, .seed = seed}));
    expect(sphere, 0);
  }
  // Its rounding errors far from the origin are large; an odd prism is not quite singular.
  expect(oracle::Prism(1001), 0.5);
}

// With the defaults: by conjugate gradients' relative, of the standard rule or of half of it.
TEST(CatmullClarkRule, CreasesOnNearlySingularMeshesConverge) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                            GenerateMesh({.kind = MeshKind::kNgons, .vertices = 562, .seed = 1}));
  const auto edges = oracle::NumberEdges(oracle::FromPolygonMesh(mesh).faces);
  for (const float sharpness : {0.1F, 0.5F, 1.0F, 2.5F, 10.0F}) {
    for (const double part : {0.2, 0.6, 1.0}) {
      SCOPED_TRACE(absl::StrCat("sharpness ", sharpness, ", part ", part));
      std::mt19937_64 random(5);
      InterpolateOptions options = {.scheme = Scheme::kCatmullClark, .level = 0};
      for (const auto& [edge, number] : edges) {
        if (std::uniform_real_distribution<double>()(random) >= part) continue;
        options.constraints.creases.push_back(
            {{static_cast<Index>(edge.first), static_cast<Index>(edge.second)}, {sharpness}});
      }
      LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result,
                                Interpolate(Context(), mesh, options));
      EXPECT_TRUE(result.solve.converged) << result.solve.residual;
      EXPECT_LE(result.solve.residual, 1e-12);
    }
  }
}

TEST(PrimalErrors, WhatBelongsToDooSabinIsRefusedByItsField) {
  const PolygonMesh mesh = oracle::ClosedMesh("tetrahedron");
  const auto expect = [&](InterpolateOptions options, const oracle::ExpectedError& error) {
    for (const Scheme scheme : {Scheme::kCatmullClark, Scheme::kLoop}) {
      options.scheme = scheme;
      oracle::ExpectError(Interpolate(Context(), mesh, options).status(), error);
    }
  };
  expect({.constraints = {.shape_handles = {{0, 1}}}},
         {Reason::kInvalidOption, "constraints.shape_handles"});
  expect({.fair = true}, {Reason::kInvalidOption, "solve.fair"});
  expect({.rule = FirstRule::kModified}, {Reason::kInvalidOption, "solve.rule"});
}

TEST(PrimalErrors, WhatBelongsToTheOthersIsRefusedForDooSabin) {
  const PolygonMesh mesh = oracle::ClosedMesh("cube");
  const auto expect = [&](const InterpolateOptions& options, const std::string& field) {
    oracle::ExpectError(Interpolate(Context(), mesh, options).status(),
                        {Reason::kInvalidOption, field});
  };
  expect({.constraints = {.creases = {{{0, 1}, {1}}}}}, "constraints.creases");
  expect({.constraints = {.corners = {{0, 1}}}}, "constraints.corners");
  expect({.constraints = {.holes = {0}}}, "constraints.holes");
  expect({.boundary = BoundaryRule::kEdgeOnly}, "surface.boundary");
  expect({.rule = FirstRule::kBilinear}, "solve.rule");
}

TEST(PrimalErrors, LoopAsksForTriangles) {
  oracle::ExpectError(
      Interpolate(Context(), oracle::ClosedMesh("cube"), {.scheme = Scheme::kLoop}).status(),
      {Reason::kInvalidOption, "mesh.faces", 0});
}

TEST(PrimalErrors, CreasesAreRefusedByTheirPath) {
  const PolygonMesh mesh = oracle::ClosedMesh("cube");
  const auto expect = [&](const Constraints& constraints, const oracle::ExpectedError& error) {
    oracle::ExpectError(
        Interpolate(Context(), mesh, {.scheme = Scheme::kCatmullClark, .constraints = constraints})
            .status(),
        error);
  };
  constexpr Reason kRange = Reason::kIndexOutOfRange;
  constexpr Reason kInvalid = Reason::kInvalidOption;
  const Index a = mesh.corner_vertex[0];
  const Index b = mesh.corner_vertex[1];
  const Index across = mesh.corner_vertex[2];
  const CreaseConstraint good = {{a, b}, {1}};
  expect({.creases = {good, {{b, 99}, {1}}}}, {kRange, "constraints.creases[1].vertices[1]", 1});
  expect({.creases = {good, {{99, b}, {1}}}}, {kRange, "constraints.creases[1].vertices[0]", 0});
  expect({.creases = {good, {{a, across}, {1}}}},
         {kInvalid, "constraints.creases[1].vertices[1]", 1});
  expect({.creases = {good, {{a}, {1}}}}, {kInvalid, "constraints.creases[1].vertices", 1});
  expect({.creases = {{{a, b, across}, {1, 2, 3}}}},
         {kInvalid, "constraints.creases[0].sharpness", 0});
  expect({.creases = {{{a, b, across}, {1, -2}}}},
         {kInvalid, "constraints.creases[0].sharpness[1]", 1});
  expect({.creases = {good, {{a, b, across}, {-1}}}},
         {kInvalid, "constraints.creases[1].sharpness[0]", 0});
  expect({.corners = {{0, 1}, {8, 1}}}, {kRange, "constraints.corners[1].vertex", 1});
  expect({.corners = {{0, std::nanf("")}}}, {kInvalid, "constraints.corners[0].sharpness", 0});
  expect({.holes = {0, 6}}, {kRange, "constraints.holes[1]", 1});
}

}  // namespace
}  // namespace limn
