// SPDX-License-Identifier: MIT
// Exact evaluation of Catmull-Clark and Loop surfaces, held against refinement of what is around
// each parameter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/limit/evaluate.h"
#include "engine/limit/vertex_limit.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/creased_level.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/followed.h"
#include "tests/oracle/primal_surface.h"

namespace limn {
namespace {

using oracle::CreasedMesh;
using oracle::Creases;
using oracle::Evaluated;
using oracle::FollowedPoint;
using oracle::Point;
using oracle::Rule;
using oracle::Samples;

Vec3 ToVec3(const Point& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

class EvaluatePrimalTest : public testing::TestWithParam<std::tuple<Rule, std::string>> {
 protected:
  EvaluatePrimalTest() {
    given_ = oracle::Jittered(oracle::MeshFor(rule(), std::get<1>(GetParam())), 17, 0.05);
    diagonal_ = static_cast<double>(oracle::Diagonal(oracle::FromVec3(given_.positions)));
  }
  static Rule rule() { return std::get<0>(GetParam()); }
  static bool Loop() { return rule() == Rule::kLoop; }

  // Plain, with smooth boundary corners, with what stays sharp, with what wears off.
  std::vector<Creases> Variants() const {
    Creases lasting = oracle::RandomCreases(given_, 1);
    for (float& sharpness : lasting.sharpnesses) sharpness = kSharpForever;
    for (float& sharpness : lasting.corner_sharpnesses) sharpness = kSharpForever;
    Creases mixed = oracle::RandomCreases(given_, 2);
    mixed.boundary = BoundaryRule::kEdgeOnly;
    return {{}, {.boundary = BoundaryRule::kEdgeOnly}, lasting, mixed};
  }

  SurfaceParameter At(std::mt19937_64& random, double u, double v) const {
    const Index face = static_cast<Index>(random() % given_.face_count());
    return {face, static_cast<Index>(random() % given_.arity(face)), u, v};
  }
  // u and v in the patch, from corner `corner` of the patch.
  SurfaceParameter From(SurfaceParameter p, std::size_t corner) const {
    const double u = p.u;
    const double v = p.v;
    if (Loop()) {
      if (corner == 1) std::tie(p.u, p.v) = std::pair((1 - u) - v, u);
      if (corner == 2) std::tie(p.u, p.v) = std::pair(v, (1 - u) - v);
      return p;
    }
    if (corner == 1) std::tie(p.u, p.v) = std::pair(1 - v, u);
    if (corner == 2) std::tie(p.u, p.v) = std::pair(1 - u, 1 - v);
    if (corner == 3) std::tie(p.u, p.v) = std::pair(v, 1 - u);
    return p;
  }
  std::pair<double, double> Inside(std::mt19937_64& random) const {
    std::uniform_real_distribution<double> coordinate(0, 1);
    const double u = coordinate(random);
    const double v = coordinate(random);
    return Loop() && u > 1 - v ? std::pair(1 - u, 1 - v) : std::pair(u, v);
  }

  // steps: until what is left is flat.
  void ExpectFollowed(const Creases& creases, double blend,
                      const std::vector<SurfaceParameter>& parameters, int steps) const {
    const PrimalSurface surface = oracle::PrimalSurfaceOf(given_, rule(), creases, blend);
    const CreasedMesh mesh = oracle::WithCreases(oracle::FromPolygonMesh(given_), creases);
    const Samples samples = Evaluated(surface, parameters);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const SurfaceParameter& p = parameters[i];
      SCOPED_TRACE(testing::Message()
                   << "face " << p.face << " corner " << p.corner << " at " << p.u << " " << p.v);
      const FollowedPoint expected = oracle::Follow(mesh, rule(), p, steps, blend);
      ASSERT_LE(Norm(samples.points[i] - ToVec3(expected.point)), 1e-14 * diagonal_);
      const Vec3 du = ToVec3(expected.du);
      const Vec3 dv = ToVec3(expected.dv);
      const double size = std::max(Norm(du), Norm(dv));
      ASSERT_LE(Norm(samples.du[i] - du), 1e-8 * size);
      ASSERT_LE(Norm(samples.dv[i] - dv), 1e-8 * size);
      const Vec3 normal = NormalizedOrZero(Cross(du, dv));
      const double flat = size * size / Norm(Cross(du, dv));
      ASSERT_LE(Norm(samples.normals[i] - normal), 1e-7 * flat);
    }
  }

  PolygonMesh given_;
  double diagonal_ = 0;
};

TEST_P(EvaluatePrimalTest, AgreesWithDeepRefinement) {
  std::mt19937_64 random(71);
  for (const Creases& creases : Variants()) {
    std::vector<SurfaceParameter> parameters;
    for (int i = 0; i < 8; ++i) {
      const auto [u, v] = Inside(random);
      parameters.push_back(At(random, u, v));
    }
    // On sides of the patch and of its quarters.
    parameters.push_back(At(random, 0.3, 0));
    parameters.push_back(At(random, 0, 0.7));
    parameters.push_back(At(random, 0.5, 0.2));
    parameters.push_back(From(At(random, 0.3, 0), 2));
    ExpectFollowed(creases, 0, parameters, 34);
  }
}

// As near as 1e-30 to each corner of the patch, in all directions.
TEST_P(EvaluatePrimalTest, NothingIsLostNearExtraordinaryVertices) {
  std::mt19937_64 random(72);
  for (const Creases& creases : Variants()) {
    for (const auto& [halvings, corners] : {std::pair(7, 4U), std::pair(20, 4U), {100, 1U}}) {
      std::vector<SurfaceParameter> parameters;
      for (std::size_t corner = 0; corner < (Loop() ? std::min(corners, 3U) : corners); ++corner) {
        const auto [u, v] = Inside(random);
        SurfaceParameter p = At(random, std::ldexp(u, -halvings), std::ldexp(v, -halvings));
        parameters.push_back(From(p, corner));
      }
      ExpectFollowed(creases, 0, parameters, halvings + 34);
    }
  }
}

// There the corners of smaller and smaller patches lie, regular ones among them.
TEST_P(EvaluatePrimalTest, NothingIsLostAtPowersOfTwo) {
  std::mt19937_64 random(74);
  for (const int halvings : {30, 50, 100}) {
    const double step = std::ldexp(1, -halvings);
    const std::vector<SurfaceParameter> parameters = {At(random, step, 0), At(random, 0, step),
                                                      At(random, step, step),
                                                      At(random, step, step / 4)};
    ExpectFollowed({}, 0, parameters, halvings + 34);
  }
}

TEST_P(EvaluatePrimalTest, KnowsTheBilinearFirstStep) {
  if (Loop()) return;
  std::mt19937_64 random(73);
  for (const double blend : {0.5, 1.0}) {
    std::vector<SurfaceParameter> parameters;
    for (int i = 0; i < 5; ++i) {
      const auto [u, v] = Inside(random);
      parameters.push_back(At(random, u, v));
    }
    ExpectFollowed({}, blend, parameters, 34);
  }
}

// All corners of patches are vertices of T^1 (Loop: T^0).
TEST_P(EvaluatePrimalTest, CornersArePointsAndNormalsOfTheLimit) {
  int everywhere = 0;
  for (const Creases& creases : Variants()) {
    const PrimalSurface surface = oracle::PrimalSurfaceOf(given_, rule(), creases);
    const std::size_t n = surface.points.size();
    std::vector<Vec3> points(n);
    std::vector<Tangents> tangents(n);
    std::vector<Vec3> normals(n);
    const VertexLimits limits = {absl::MakeSpan(points), absl::MakeSpan(tangents),
                                 absl::MakeSpan(normals)};
    const SurfaceLevel level = {surface.mesh, surface.sharpness};
    ASSERT_TRUE((Loop() ? LoopLimits(Context(), level, surface.points, limits)
                        : CatmullClarkLimits(Context(), level, surface.points, limits))
                    .ok());
    std::vector<SurfaceParameter> parameters;
    std::vector<Index> vertices;
    Index patch = 0;
    for (Index f = 0; f < given_.face_count(); ++f) {
      for (Index c = 0; c < given_.arity(f); ++c, ++patch) {
        for (Index i = 0; i < (Loop() ? 3 : 4); ++i) {
          parameters.push_back(From({f, c, 0, 0}, i));
          vertices.push_back(surface.mesh.vertex()[Loop() ? 3 * f + (c + i) % 3 : 4 * patch + i]);
        }
      }
    }
    const Samples samples = Evaluated(surface, parameters);
    int compared = 0;
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const Index v = vertices[i];
      ASSERT_LE(Norm(samples.points[i] - points[v]), 1e-14 * diagonal_);
      // One surface, without an edge in it, and with a plane.
      const bool smooth = WithWalk(surface.mesh, [&](auto walk) {
        bool all = !surface.sharpness.creased() || surface.sharpness.vertex[v] == 0;
        VisitFan(walk, surface.mesh.twin(), surface.mesh.vertex_half_edge()[v], [&](Index h) {
          if (surface.sharpness.creased() && surface.mesh.twin()[h] != kNoIndex &&
              surface.sharpness.edge[surface.mesh.edge()[h]] > 0) {
            all = false;
          }
        });
        return all;
      });
      if (!smooth) continue;
      ASSERT_LE(Norm(samples.normals[i] - normals[v]), 1e-9);
      ++compared;
    }
    everywhere += compared;
  }
  EXPECT_GT(everywhere, 0);
}

// Neighbouring patches share their sides, and their planes where nothing is sharp.
TEST_P(EvaluatePrimalTest, PatchesMeet) {
  const PrimalSurface surface = oracle::PrimalSurfaceOf(given_, rule(), Variants()[3]);
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given_);
  const PolygonWalk walk(mesh);
  std::vector<SurfaceParameter> parameters;
  const auto at = [&](Index h, double u, double v) {
    parameters.push_back(oracle::AtHalfEdge(mesh, h, u, v));
  };
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    const Index t = mesh.twin()[h];
    if (t == kNoIndex) continue;
    // Along the edge: from the vertex on, on both sides.
    at(h, 0.25, 0);
    if (Loop()) {
      at(t, 0.75, 0);
    } else {
      at(walk.Next(t), 0, 0.25);
    }
  }
  const Samples samples = Evaluated(surface, parameters);
  for (std::size_t i = 0; i < parameters.size(); i += 2) {
    ASSERT_LE(Norm(samples.points[i] - samples.points[i + 1]), 1e-14 * diagonal_);
    const Index h = mesh.face_begin()[parameters[i].face] + parameters[i].corner;
    const Index edge = surface.mesh.edge()[Loop() ? h : 4 * h];
    if (surface.sharpness.creased() && surface.sharpness.edge[edge] >= kSharpForever) continue;
    ASSERT_LE(Norm(samples.normals[i] - samples.normals[i + 1]), 1e-9);
  }
}

// Nearer than doubles of ordinary size, along sides and between them.
TEST_P(EvaluatePrimalTest, DenormalParametersHaveTheirVerticesPoint) {
  const PrimalSurface surface = oracle::PrimalSurfaceOf(given_, rule(), Variants()[2]);
  const double tiny = 5e-324;
  for (Index f = 0; f < given_.face_count(); f += 5) {
    const Samples samples = Evaluated(
        surface, {{f, 0, 0, 0}, {f, 0, tiny, 0}, {f, 0, 0, 3 * tiny}, {f, 0, tiny, 1e-300}});
    for (std::size_t i = 1; i < 4; ++i) {
      ASSERT_LE(Norm(samples.points[i] - samples.points[0]), 1e-14 * diagonal_);
      ASSERT_TRUE(IsFinite(samples.du[i]) && IsFinite(samples.dv[i]));
      ASSERT_TRUE(IsFinite(samples.normals[i]));
    }
  }
}

// The same parameters of the same surface, held by finer nets.
TEST_P(EvaluatePrimalTest, TheDepthOfTheNetDoesNotMatter) {
  std::mt19937_64 random(78);
  for (const Creases& creases : Variants()) {
    const PrimalSurface coarse = oracle::PrimalSurfaceOf(given_, rule(), creases);
    std::vector<SurfaceParameter> parameters;
    for (int i = 0; i < 60; ++i) {
      const auto [u, v] = Inside(random);
      parameters.push_back(At(random, u, v));
    }
    for (const auto& [u, v] : {std::pair(0.3, 0.0), {0.0, 0.7}, {0.5, 0.2}, {0.25, 0.75}}) {
      parameters.push_back(At(random, u, v));
    }
    const Samples expected = Evaluated(coarse, parameters);
    oracle::CreasedLevel level(given_, rule(), creases);
    for (std::uint32_t depth = 0; depth <= 3; ++depth) {
      if (!Loop() || depth > 0) level.Refine();
      const PrimalSurface fine = {.kind = coarse.kind,
                                  .mesh = level.mesh,
                                  .sharpness = level.sharpness,
                                  .points = level.points,
                                  .face_begin = coarse.face_begin,
                                  .depth = depth};
      EXPECT_EQ(fine.face_count(), coarse.face_count());
      const Samples samples = Evaluated(fine, parameters);
      for (std::size_t i = 0; i < parameters.size(); ++i) {
        const SurfaceParameter& p = parameters[i];
        SCOPED_TRACE(testing::Message() << "depth " << depth << " face " << p.face << " corner "
                                        << p.corner << " at " << p.u << " " << p.v);
        const double size = std::max(Norm(expected.du[i]), Norm(expected.dv[i]));
        ASSERT_LE(Norm(samples.points[i] - expected.points[i]), 1e-14 * diagonal_);
        ASSERT_LE(Norm(samples.du[i] - expected.du[i]), 1e-9 * size);
        ASSERT_LE(Norm(samples.dv[i] - expected.dv[i]), 1e-9 * size);
        ASSERT_LE(Norm(samples.normals[i] - expected.normals[i]), 1e-8);
      }
    }
  }
}

std::vector<std::string> Names() {
  return {"cube",          "prism_3",        "prism_7_jittered_seed_4",
          "pillow_3",      "valence_two",    "smallest_torus",
          "ngons_seed_2",  "antiprism_5",    "antiprism_40",
          "TubeOfOneRing", "CubeWithoutLid", "TwoPatches",
          "ShuffledPatch"};
}
std::string NameOf(const testing::TestParamInfo<std::tuple<Rule, std::string>>& info) {
  return (std::get<0>(info.param) == Rule::kLoop ? "Loop_" : "CatmullClark_") +
         std::get<1>(info.param);
}
INSTANTIATE_TEST_SUITE_P(All, EvaluatePrimalTest,
                         testing::Combine(testing::Values(Rule::kCatmullClark, Rule::kLoop),
                                          testing::ValuesIn(Names())),
                         NameOf);

}  // namespace
}  // namespace limn
