// SPDX-License-Identifier: MIT
#include "engine/limit/evaluate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/generate.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/expect.h"

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
using oracle::SomeParameters;

constexpr std::size_t kDeepQuads = 400'000;

// Faces of every kind: vertex faces and faces of 3 to 8 and of many sides, alone and together.
std::vector<std::string> ExtraordinaryNames() {
  return {"cube",        "dodecahedron",       "prism_6",         "prism_8",
          "prism_40",    "antiprism_5",        "antiprism_7",     "antiprism_40",
          "pyramid_3",   "pyramid_6",          "pyramid_8",       "pyramid_40",
          "pyramid_200", "torus_of_triangles", "irregular_seed_2"};
}
PolygonMesh ExtraordinaryMesh(const std::string& name) {
  const std::size_t at = name.rfind('_') + 1;
  const int n = at > 0 && std::isdigit(name[at]) != 0 ? std::stoi(name.substr(at)) : 0;
  if (name.starts_with("prism")) return oracle::Prism(n);
  if (name.starts_with("antiprism")) return oracle::Antiprism(n);
  if (name.starts_with("pyramid")) return oracle::DoublePyramid(n);
  if (name.starts_with("irregular")) {
    return *GenerateMesh({.vertices = 60, .seed = static_cast<std::uint64_t>(n)});
  }
  return oracle::ClosedMesh(name);
}

class EvaluateTest : public testing::TestWithParam<std::string> {
 protected:
  EvaluateTest() : surface_(RandomSurface(ExtraordinaryMesh(GetParam()), 41)) {}
  const DooSabinSurface surface_;
};

TEST_P(EvaluateTest, AgreesWithDeepRefinement) {
  const DeepSurface deep = Refined(surface_, oracle::DeepLevel(surface_.mesh, kDeepQuads));
  const GridParameters grid = AllOf(surface_, deep);
  const Samples samples = Evaluated(surface_, grid.parameters);
  for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
    const SurfaceParameter& p = grid.parameters[i];
    ASSERT_LE(MaxAbs(samples.points[i] - deep.points[grid.vertices[i]]), 1e-14)
        << p.face << " " << p.corner << " " << p.u << " " << p.v;
    // With points at random some derivatives are nearly parallel.
    ASSERT_LE(MaxAbs(samples.normals[i] - deep.normals[grid.vertices[i]]), 1e-8)
        << p.face << " " << p.corner << " " << p.u << " " << p.v;
  }
}

// Between neighbours inside a piece the surface is quadratic, and so its central difference
// quotients are its derivatives, whatever the step.
TEST_P(EvaluateTest, DerivativesAreDifferenceQuotientsOfDeepRefinement) {
  const DeepSurface deep = Refined(surface_, oracle::DeepLevel(surface_.mesh, kDeepQuads));
  const std::size_t n = deep.cells;
  ASSERT_GE(n, 4U);
  std::vector<SurfaceParameter> parameters;
  std::vector<Vec3> du;
  std::vector<Vec3> dv;
  const auto quotient = [&](Index after, Index before) {
    return 0.5 * static_cast<double>(n) * (deep.points[after] - deep.points[before]);
  };
  for (Index h = 0; h < surface_.mesh.half_edge_count(); ++h) {
    for (std::size_t j = 1; j < n; j += 2) {
      for (std::size_t i = 1; i < n; i += 2) {
        // Next to (0, 0) and (1, 1) the pieces are smaller than the step.
        if (std::max(i, j) < 2 || std::min(i, j) > n - 2) continue;
        parameters.push_back(AtHalfEdge(surface_.mesh, h, deep.At(i), deep.At(j)));
        du.push_back(quotient(deep.VertexAt(h, i + 1, j), deep.VertexAt(h, i - 1, j)));
        dv.push_back(quotient(deep.VertexAt(h, i, j + 1), deep.VertexAt(h, i, j - 1)));
      }
    }
  }
  const Samples samples = Evaluated(surface_, parameters);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    ASSERT_LE(MaxAbs(samples.du[i] - du[i]), 1e-14 * static_cast<double>(n)) << i;
    ASSERT_LE(MaxAbs(samples.dv[i] - dv[i]), 1e-14 * static_cast<double>(n)) << i;
  }
}

// In pieces of every size, as far as differences of points have digits left.
TEST_P(EvaluateTest, DerivativesAreDifferenceQuotientsOfPoints) {
  constexpr std::array<std::pair<double, double>, 3> kPlaces = {
      {{0.8, 0.3}, {0.2, 0.7}, {0.6, 0.9}}};
  for (Index h = 0; h < surface_.mesh.half_edge_count(); h += 3) {
    for (int k = 0; k <= 20; ++k) {
      const double size = std::ldexp(1, -k);
      // One of three pieces each time, next to (0, 0) and to (1, 1).
      const auto [x, y] = kPlaces[h % 3];
      for (const bool far : {false, true}) {
        const auto at = [&](double u, double v) {
          return AtHalfEdge(surface_.mesh, h, far ? 1 - u * size : u * size,
                            far ? 1 - v * size : v * size);
        };
        constexpr double kStep = 0.0625;
        // (1, 1) is approached from the far half only.
        if (far && k == 0) continue;
        const Samples s = Evaluated(surface_, {at(x, y), at(x + kStep, y), at(x - kStep, y),
                                               at(x, y + kStep), at(x, y - kStep)});
        const double scale = (far ? -0.5 : 0.5) / (kStep * size);
        const double tolerance = 1e-14 / size;
        ASSERT_LE(MaxAbs(s.du[0] - scale * (s.points[1] - s.points[2])), tolerance) << k;
        ASSERT_LE(MaxAbs(s.dv[0] - scale * (s.points[3] - s.points[4])), tolerance) << k;
      }
    }
  }
}

TEST_P(EvaluateTest, IsTheSameSurfaceAfterRefinement) {
  DooSabinSurface surface = surface_;
  std::vector<SurfaceParameter> parameters = SomeParameters(surface.mesh, 3000, 42);
  // Beside a line of pieces derivatives have two values.
  std::erase_if(parameters, [](const SurfaceParameter& p) {
    return std::max(p.u, p.v) == 0.5 || std::min(p.u, p.v) == 0.5;
  });
  for (int step = 0; step < 2; ++step) {
    SCOPED_TRACE(step);
    const Samples coarse = Evaluated(surface, parameters);
    std::vector<SurfaceParameter> finer;
    for (const SurfaceParameter& p : parameters) finer.push_back(RefinedParameter(surface, p));
    surface = RefinedSurface(surface);
    const Samples fine = Evaluated(surface, finer);
    for (std::size_t i = 0; i < finer.size(); ++i) {
      ASSERT_LE(MaxAbs(coarse.points[i] - fine.points[i]), 1e-14) << i;
      // Each quarter's u and v in terms of the whole patch's.
      const Vec3 u = 2 * fine.du[i];
      const Vec3 v = 2 * fine.dv[i];
      const Vec3 du[4] = {u, -v, -u, v};
      const Vec3 dv[4] = {v, u, -v, -u};
      ASSERT_LE(MaxAbs(coarse.du[i] - du[finer[i].corner]), 1e-13) << i;
      ASSERT_LE(MaxAbs(coarse.dv[i] - dv[finer[i].corner]), 1e-13) << i;
    }
    parameters = finer;
  }
}

// Patch h and the next one of its face share the side from the edge to the face; patch h and the
// clockwise one at its vertex share the side from the vertex to the edge.
TEST_P(EvaluateTest, PatchesThatShareASideAgreeOnIt) {
  const HalfEdgeMesh& mesh = surface_.mesh;
  const PolygonWalk walk(mesh);
  std::vector<SurfaceParameter> mine;
  std::vector<SurfaceParameter> inner;
  std::vector<SurfaceParameter> outer;
  std::vector<SurfaceParameter> outer_mine;
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    for (const double t : {1e-300, 1e-9, 0.125, 0.3, 0.5, 0.71, 0.875, 1 - 1e-9}) {
      mine.push_back(AtHalfEdge(mesh, h, 1, t));
      inner.push_back(AtHalfEdge(mesh, walk.Next(h), t, 1));
      outer_mine.push_back(AtHalfEdge(mesh, h, t, 0));
      outer.push_back(AtHalfEdge(mesh, RotateCw(walk, mesh.twin(), h), 0, t));
    }
  }
  const Samples a = Evaluated(surface_, mine);
  const Samples b = Evaluated(surface_, inner);
  const Samples c = Evaluated(surface_, outer_mine);
  const Samples d = Evaluated(surface_, outer);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    EXPECT_LE(MaxAbs(a.points[i] - b.points[i]), 1e-14);
    EXPECT_LE(MaxAbs(a.dv[i] - b.du[i]), 1e-13);
    EXPECT_LE(MaxAbs(a.du[i] + b.dv[i]), 1e-13);
    EXPECT_LE(MaxAbs(a.normals[i] - b.normals[i]), 1e-8);
    EXPECT_LE(MaxAbs(c.points[i] - d.points[i]), 1e-14);
    EXPECT_LE(MaxAbs(c.du[i] - d.dv[i]), 1e-13);
    EXPECT_LE(MaxAbs(c.dv[i] + d.du[i]), 1e-13);
    EXPECT_LE(MaxAbs(c.normals[i] - d.normals[i]), 1e-8);
  }
}

TEST_P(EvaluateTest, CornersOfPatchesAreLimitPointsAndNormals) {
  const DeepSurface limit = Refined(surface_, 1);
  const GridParameters grid = AllOf(surface_, limit);
  const Samples samples = Evaluated(surface_, grid.parameters);
  for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
    EXPECT_LE(MaxAbs(samples.points[i] - limit.points[grid.vertices[i]]), 1e-15);
    EXPECT_LE(MaxAbs(samples.normals[i] - limit.normals[grid.vertices[i]]), 1e-10);
  }
}

// Towards (0, 0) and (1, 1), from all directions, in steps of halves.
TEST_P(EvaluateTest, ApproachesExtraordinaryPointsWithoutLoss) {
  constexpr int kHalvings = 1074;
  for (Index h = 0; h < surface_.mesh.half_edge_count(); h += 7) {
    for (const auto& [x, y] : {std::pair(1.0, 0.0), {0.0, 1.0}, {1.0, 1.0}, {0.75, 1.0}}) {
      SCOPED_TRACE(testing::Message() << h << " from " << x << " " << y);
      std::vector<SurfaceParameter> parameters = {AtHalfEdge(surface_.mesh, h, 0, 0)};
      for (int j = 0; j <= kHalvings; ++j) {
        parameters.push_back(AtHalfEdge(surface_.mesh, h, std::ldexp(x, -j), std::ldexp(y, -j)));
      }
      const Samples samples = Evaluated(surface_, parameters);
      const Vec3 centre = samples.points[0];
      const Vec3 last_du = samples.du[1000];
      const Vec3 last_dv = samples.dv[1000];
      for (int j = 10; j < kHalvings; ++j) {
        const auto i = static_cast<std::size_t>(j + 1);
        // Distance and derivatives settle at rate 2^-j; rounding adds 1e-15.
        const double near = std::ldexp(1, -j);
        ASSERT_LE(MaxAbs(samples.points[i] - centre), 30 * near);
        if (j < 40) {
          ASSERT_LE(Norm(samples.points[i + 1] - centre), Norm(samples.points[i] - centre));
        }
        // 0.75 * 2^-j is not exact among the smallest numbers.
        if (x == 0.75 && j > 1072) continue;
        ASSERT_LE(MaxAbs(samples.du[i] - last_du), 300 * near + 1e-14) << j;
        ASSERT_LE(MaxAbs(samples.dv[i] - last_dv), 300 * near + 1e-14) << j;
        ASSERT_LE(MaxAbs(samples.normals[i] - samples.normals[0]), 1e5 * near + 1e-7) << j;
      }
    }
  }
}

TEST_P(EvaluateTest, DerivativesAtExtraordinaryPointsAreThoseAlongTheSides) {
  for (Index h = 0; h < surface_.mesh.half_edge_count(); ++h) {
    std::vector<SurfaceParameter> parameters;
    for (const double t : {0.0, 1e-300, 1e-13}) {
      parameters.push_back(AtHalfEdge(surface_.mesh, h, t, 0));
      parameters.push_back(AtHalfEdge(surface_.mesh, h, 0, t));
    }
    for (const double t : {0.0, 0x1p-53, 0x1p-43}) {
      parameters.push_back(AtHalfEdge(surface_.mesh, h, 1 - t, 1));
      parameters.push_back(AtHalfEdge(surface_.mesh, h, 1, 1 - t));
    }
    const Samples samples = Evaluated(surface_, parameters);
    for (const std::size_t corner : {0, 6}) {
      EXPECT_EQ(samples.du[corner], samples.du[corner + 1]);
      EXPECT_EQ(samples.dv[corner], samples.dv[corner + 1]);
      for (const std::size_t i : {corner + 2, corner + 4}) {
        // Some hundred times as much as the distance, at most 2^-43.
        EXPECT_LE(MaxAbs(samples.du[i] - samples.du[corner]), 1e-10);
        EXPECT_LE(MaxAbs(samples.dv[i + 1] - samples.dv[corner]), 1e-10);
      }
    }
  }
}

TEST_P(EvaluateTest, PointsAtVerticesAreThoseOfTheTessellationToTheBit) {
  const DeepSurface limit = Refined(surface_, 1);
  const GridParameters grid = AllOf(surface_, limit);
  const Samples samples = Evaluated(surface_, grid.parameters);
  const HalfEdgeMesh& mesh = surface_.mesh;
  for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
    const SurfaceParameter& p = grid.parameters[i];
    const Index h = mesh.face_begin()[p.face] + p.corner;
    const std::size_t arity = mesh.face_begin()[p.face + 1] - mesh.face_begin()[p.face];
    const bool at_vertex = p.u == 0 && p.v == 0 && mesh.valence(mesh.vertex()[h]) != 4;
    const bool at_face = p.u == 1 && p.v == 1 && arity != 4;
    if (!at_vertex && !at_face) continue;
    EXPECT_EQ(samples.points[i], limit.points[grid.vertices[i]]);
    EXPECT_EQ(samples.normals[i], limit.normals[grid.vertices[i]]);
  }
}

INSTANTIATE_TEST_SUITE_P(Extraordinary, EvaluateTest, testing::ValuesIn(ExtraordinaryNames()),
                         [](const auto& mesh) { return mesh.param; });

class EvaluateClosedTest : public oracle::ClosedMeshTest {};

TEST_P(EvaluateClosedTest, PassesThroughTheVertices) {
  const DooSabinSurface surface = oracle::InterpolatingSurface(mesh_);
  std::vector<SurfaceParameter> parameters;
  for (Index h = 0; h < surface.mesh.half_edge_count(); ++h) {
    parameters.push_back(AtHalfEdge(surface.mesh, h, 0, 0));
  }
  const Samples samples = Evaluated(surface, parameters);
  for (std::size_t h = 0; h < parameters.size(); ++h) {
    EXPECT_LE(MaxAbs(samples.points[h] - mesh_.positions[surface.mesh.vertex()[h]]),
              1e-15 * static_cast<double>(oracle::Diagonal(given_.points)));
  }
}

TEST_P(EvaluateClosedTest, AgreesWithDeepRefinement) {
  const DooSabinSurface surface = oracle::InterpolatingSurface(mesh_);
  const DeepSurface deep = Refined(surface, oracle::DeepLevel(surface.mesh, kDeepQuads));
  const GridParameters grid = AllOf(surface, deep);
  const Samples samples = Evaluated(surface, grid.parameters);
  const auto diagonal = static_cast<double>(oracle::Diagonal(given_.points));
  for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
    ASSERT_LE(MaxAbs(samples.points[i] - deep.points[grid.vertices[i]]), 1e-14 * diagonal) << i;
  }
}

LIMN_FOR_CLOSED_MESHES(EvaluateClosedTest);

}  // namespace
}  // namespace limn
