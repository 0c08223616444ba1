// SPDX-License-Identifier: MIT
// The guarantees of the whole job on open meshes, and of constraints on all meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/open_doo_sabin.h"
#include "tests/oracle/open_meshes.h"

namespace limn {
namespace {

using oracle::Points;
using oracle::Real;

InterpolateResult InterpolateOrDie(const PolygonMesh& mesh,
                                   const InterpolateOptions& options = {}) {
  auto result = Interpolate(Context(), mesh, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return result.ok() ? *std::move(result) : InterpolateResult{};
}

void ExpectIsTheOracles(const PolygonMesh& mesh, const InterpolateOptions& options,
                        const oracle::Wishes& wishes) {
  const oracle::Mesh given = oracle::FromPolygonMesh(mesh);
  const Real size = oracle::Diagonal(given.points);
  const oracle::Interpolated expected =
      oracle::InterpolateOpen(given, wishes, static_cast<int>(options.level));
  const InterpolateResult result = InterpolateOrDie(mesh, options);
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.control_positions), expected.control),
            2e-12 * size);
  ASSERT_EQ(result.surface.vertex_count(), expected.points.size());
  ASSERT_EQ(result.surface.face_count(), expected.tiling.faces.size());
  for (std::size_t f = 0; f < result.surface.face_count(); ++f) {
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_EQ(static_cast<int>(result.surface.face_vertices[4 * f + i]),
                expected.tiling.faces[f][i]);
    }
  }
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.surface.positions), expected.points),
            1e-11 * size);
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.surface.normals), expected.normals), 1e-8);
}

Real ErrorAt(const PolygonMesh& mesh, const InterpolateResult& result, Index v) {
  return oracle::Norm(oracle::FromVec3({mesh.positions[v]})[0] -
                      oracle::FromVec3({result.surface.positions[v]})[0]);
}

class InterpolateOpenTest : public testing::TestWithParam<std::string> {
 protected:
  const PolygonMesh mesh_ = oracle::OpenMesh(GetParam());
  const oracle::Mesh given_ = oracle::FromPolygonMesh(mesh_);
  const Real size_ = oracle::Diagonal(given_.points);
};

TEST_P(InterpolateOpenTest, SurfaceIsTheOraclesAtEveryLevel) {
  for (const std::uint32_t level : {1U, 2U, 3U}) {
    SCOPED_TRACE(level);
    ExpectIsTheOracles(mesh_, {.level = level}, {});
  }
}

TEST_P(InterpolateOpenTest, StandardRuleIsTheOraclesToo) {
  ExpectIsTheOracles(mesh_, {.rule = FirstRule::kStandard, .level = 2}, {.standard_rule = true});
}

TEST_P(InterpolateOpenTest, AllVerticesAreMetWhateverTheSolve) {
  for (const SolveMethod method :
       {SolveMethod::kChebyshev, SolveMethod::kJacobi, SolveMethod::kGaussSeidel}) {
    for (const std::uint32_t sweeps : {0U, 2U, 100U}) {
      const InterpolateResult result =
          InterpolateOrDie(mesh_, {.solve = {.method = method, .max_sweeps = sweeps}, .level = 2});
      for (Index v = 0; v < mesh_.vertex_count(); ++v) {
        ASSERT_LE(ErrorAt(mesh_, result, v), 1e-12 * size_) << v;
      }
    }
  }
}

TEST_P(InterpolateOpenTest, ResidualOfTheWholeControlMeshIsSmall) {
  const InterpolateResult result = InterpolateOrDie(mesh_, {.surface = false});
  EXPECT_TRUE(result.solve.converged);
  EXPECT_LE(result.solve.residual, 1e-12);
  EXPECT_LE(result.solve.sweeps, 18U);
}

TEST_P(InterpolateOpenTest, SubsetsNormalsAndHandlesAreTheOracles) {
  InterpolateOptions options = {.level = 2};
  oracle::Wishes wishes;
  wishes.interpolated.assign(mesh_.vertex_count(), false);
  options.constraints.interpolate.emplace();
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    if (v % 3 == 1) continue;
    options.constraints.interpolate->push_back(v);
    wishes.interpolated[v] = true;
    if (v % 3 == 0) {
      const Vec3 n = {0.1 + 0.02 * v, -0.2, 2};
      options.constraints.normals.push_back({v, n});
      wishes.normals[static_cast<int>(v)] = oracle::FromVec3({n})[0];
    }
  }
  for (Index v = 0; v < mesh_.vertex_count(); v += 2) {
    const double value = v % 4 == 0 ? 0.4 : 2.5;
    options.constraints.shape_handles.push_back({v, value});
    wishes.handles[static_cast<int>(v)] = value;
  }
  ExpectIsTheOracles(mesh_, options, wishes);
  const InterpolateResult result = InterpolateOrDie(mesh_, options);
  for (const Index v : *options.constraints.interpolate) {
    EXPECT_LE(ErrorAt(mesh_, result, v), 1e-12 * size_) << v;
  }
  for (const NormalConstraint& wish : options.constraints.normals) {
    const Vec3 n = result.surface.normals[wish.vertex];
    EXPECT_LE(Norm(Cross(n, wish.normal)) / Norm(wish.normal), 1e-10) << wish.vertex;
    EXPECT_NEAR(Norm(n), 1, 1e-12) << wish.vertex;
  }
}

TEST_P(InterpolateOpenTest, EveryLevelHasTheEulerCharacteristicOfTheInput) {
  const int euler = oracle::EulerCharacteristic(oracle::TilingOf(given_));
  for (const std::uint32_t level : {1U, 2U, 3U}) {
    const Tessellation surface = InterpolateOrDie(mesh_, {.level = level}).surface;
    oracle::Tiling tiling = {static_cast<int>(surface.vertex_count()), {}};
    for (std::size_t f = 0; f < surface.face_count(); ++f) {
      const Index* q = &surface.face_vertices[4 * f];
      tiling.faces.push_back({static_cast<int>(q[0]), static_cast<int>(q[1]),
                              static_cast<int>(q[2]), static_cast<int>(q[3])});
    }
    EXPECT_EQ(oracle::EulerCharacteristic(tiling), euler);
  }
}

TEST_P(InterpolateOpenTest, OneThreadAndManyGiveTheSameBits) {
  const PolygonMesh& mesh = mesh_;
  const auto run = [&] { return InterpolateOrDie(mesh, {.level = 4}); };
  const InterpolateResult one = oracle::WithThreads(1, run);
  const InterpolateResult four = oracle::WithThreads(4, run);
  EXPECT_TRUE(one.surface.positions == four.surface.positions);
  EXPECT_TRUE(one.surface.normals == four.surface.normals);
  EXPECT_TRUE(one.control_positions == four.control_positions);
}

// The boundary of the surface in points of level 4, as runs from vertex to vertex.
TEST_P(InterpolateOpenTest, BoundaryIsTheQuadraticSplineOfTheBoundaryControlPoints) {
  const InterpolateResult result = InterpolateOrDie(mesh_, {.level = 1});
  const HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  const PolygonWalk walk(mesh);
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    if (mesh.twin()[h] != kNoIndex) continue;
    // The spline's point between two control points is their mean.
    const Vec3 a = result.control_positions[mesh.vertex()[h]];
    const Vec3 b = result.control_positions[mesh.vertex()[walk.Next(h)]];
    const Vec3 point = result.surface.positions[mesh.vertex_count() + mesh.edge()[h]];
    EXPECT_LE(MaxAbs(point - 0.5 * (a + b)), 1e-13 * static_cast<double>(size_)) << h;
  }
}

TEST_P(InterpolateOpenTest, BoundaryDependsOnBoundaryVerticesOnly) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(mesh_);
  PolygonMesh moved = mesh_;
  std::vector<bool> on_boundary(mesh.vertex_count(), false);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    on_boundary[v] = mesh.twin()[mesh.vertex_half_edge()[v]] == kNoIndex;
    if (!on_boundary[v]) moved.positions[v] += Vec3{0.3, -0.2, 0.7};
  }
  const InterpolateResult a = InterpolateOrDie(mesh_, {.level = 3});
  const InterpolateResult b = InterpolateOrDie(moved, {.level = 3});
  PolygonMesh finest;
  finest.positions = a.surface.positions;
  for (std::size_t f = 0; f < a.surface.face_count(); ++f) {
    finest.AddFace(absl::MakeConstSpan(a.surface.face_vertices).subspan(4 * f, 4));
  }
  const HalfEdgeMesh tiles = oracle::BuildOrDie(finest);
  std::size_t checked = 0;
  for (Index h = 0; h < tiles.half_edge_count(); ++h) {
    if (tiles.twin()[h] != kNoIndex) continue;
    const Index v = tiles.vertex()[h];
    EXPECT_EQ(a.surface.positions[v], b.surface.positions[v]) << v;
    ++checked;
  }
  EXPECT_EQ(checked, 8 * mesh.boundary_edge_count());
}

INSTANTIATE_TEST_SUITE_P(Open, InterpolateOpenTest, testing::ValuesIn(oracle::OpenMeshNames()),
                         [](const auto& mesh) { return mesh.param; });

class InterpolateConstraintsTest : public oracle::ClosedMeshTest {};

TEST_P(InterpolateConstraintsTest, SubsetsNormalsAndHandlesAreTheOracles) {
  if (mesh_.corner_count() > 300) return;
  InterpolateOptions options = {.level = 2};
  oracle::Wishes wishes;
  wishes.interpolated.assign(mesh_.vertex_count(), false);
  options.constraints.interpolate.emplace();
  for (Index v = 0; v < mesh_.vertex_count(); v += 2) {
    options.constraints.interpolate->push_back(v);
    wishes.interpolated[v] = true;
  }
  for (Index v = 0; v < mesh_.vertex_count(); v += 3) {
    options.constraints.shape_handles.push_back({v, 0.7});
    wishes.handles[static_cast<int>(v)] = 0.7;
  }
  ExpectIsTheOracles(mesh_, options, wishes);
}

TEST_P(InterpolateConstraintsTest, StandardRuleIsTheOracles) {
  if (mesh_.corner_count() > 300) return;
  ExpectIsTheOracles(mesh_, {.rule = FirstRule::kStandard, .level = 2}, {.standard_rule = true});
}

TEST_P(InterpolateConstraintsTest, StandardRuleTakesAtMost25ChebyshevSweepsTo1e12) {
  const InterpolateResult result =
      InterpolateOrDie(mesh_, {.rule = FirstRule::kStandard, .surface = false});
  EXPECT_TRUE(result.solve.converged);
  EXPECT_LE(result.solve.sweeps, 28U);
  EXPECT_LE(result.solve.residual, 1e-12);
}

LIMN_FOR_CLOSED_MESHES(InterpolateConstraintsTest);

}  // namespace
}  // namespace limn
