// SPDX-License-Identifier: MIT
// The guarantees of the whole job on open meshes, and of constraints on all meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "tests/engine/allocation_meter.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/open_doo_sabin.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/slowdown.h"

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

// Points of the boundary of T^k, as a set that does not depend on numbering.
std::vector<Vec3> BoundaryPoints(const Tessellation& surface) {
  PolygonMesh tiles;
  tiles.positions = surface.positions;
  for (std::size_t f = 0; f < surface.face_count(); ++f) {
    tiles.AddFace(absl::MakeConstSpan(surface.face_vertices).subspan(4 * f, 4));
  }
  const HalfEdgeMesh mesh = oracle::BuildOrDie(tiles);
  std::vector<Vec3> points;
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    if (mesh.twin()[h] == kNoIndex) points.push_back(surface.positions[mesh.vertex()[h]]);
  }
  std::sort(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  });
  return points;
}

// Another surface with the same boundary polygon, on the other side of it: one ring of quads that
// goes on to a ring far away.
TEST_P(InterpolateOpenTest, NeighboursShareTheirBoundaryToTheLastBit) {
  for (const Vec3& offset : {Vec3{0, 0, 0}, Vec3{3e5, -2e5, 1e5}}) {
    PolygonMesh near = mesh_;
    for (Vec3& p : near.positions) p += offset;
    const HalfEdgeMesh mesh = oracle::BuildOrDie(near);
    const PolygonWalk walk(mesh);
    // Corners of one and not of the other would end the curve's pieces differently.
    bool corners = false;
    PolygonMesh other;
    std::vector<Index> copy(mesh.vertex_count(), kNoIndex);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (mesh.twin()[mesh.vertex_half_edge()[v]] != kNoIndex) continue;
      corners = corners || mesh.valence(v) == 1;
      copy[v] = static_cast<Index>(other.vertex_count());
      other.positions.push_back(near.positions[v]);
      other.positions.push_back(near.positions[v] + Vec3{0.5, 40, -3});
    }
    if (corners) return;
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
      if (mesh.twin()[h] != kNoIndex) continue;
      const Index a = copy[mesh.vertex()[h]];
      const Index b = copy[mesh.vertex()[walk.Next(h)]];
      other.AddFace({b, a, a + 1, b + 1});
    }
    const std::vector<Vec3> here = BoundaryPoints(InterpolateOrDie(near, {.level = 3}).surface);
    const std::vector<Vec3> there = BoundaryPoints(InterpolateOrDie(other, {.level = 3}).surface);
    EXPECT_EQ(2 * here.size(), there.size());
    EXPECT_TRUE(std::includes(there.begin(), there.end(), here.begin(), here.end(),
                              [](const Vec3& a, const Vec3& b) {
                                return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
                              }));
  }
}

INSTANTIATE_TEST_SUITE_P(Open, InterpolateOpenTest, testing::ValuesIn(oracle::OpenMeshNames()),
                         [](const auto& mesh) { return mesh.param; });

class InterpolateConstraintsTest : public oracle::ClosedMeshTest {};

TEST_P(InterpolateConstraintsTest, SubsetsNormalsAndHandlesAreTheOracles) {
  // The oracle takes seconds for the larger ones at level 2.
  InterpolateOptions options = {.level = mesh_.corner_count() > 300 ? 1U : 2U};
  oracle::Wishes wishes;
  wishes.interpolated.assign(mesh_.vertex_count(), false);
  options.constraints.interpolate.emplace();
  const std::vector<int> faces = oracle::FacesAround(given_);
  std::vector<Vec3> areas(mesh_.vertex_count(), Vec3{0, 0, 0});
  for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
    const auto face = mesh_.face(f);
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      const Vec3& a = mesh_.positions[face[0]];
      const Vec3 area = Cross(mesh_.positions[face[i]] - a, mesh_.positions[face[i + 1]] - a);
      for (const Index v : face) areas[v] += area;
    }
  }
  for (Index v = 0; v < mesh_.vertex_count(); v += 2) {
    options.constraints.interpolate->push_back(v);
    wishes.interpolated[v] = true;
    // Vertices of two faces have no normal.
    if (v % 4 != 0 || faces[v] == 2) continue;
    // Not across the surface: faces would be turned.
    const Vec3 n = NormalizedOrZero(areas[v]) + Vec3{0.2, -0.3, 0.1};
    options.constraints.normals.push_back({v, n});
    wishes.normals[static_cast<int>(v)] = oracle::FromVec3({n})[0];
  }
  for (Index v = 0; v < mesh_.vertex_count(); v += 3) {
    options.constraints.shape_handles.push_back({v, 0.7});
    wishes.handles[static_cast<int>(v)] = 0.7;
  }
  ExpectIsTheOracles(mesh_, options, wishes);
}

TEST_P(InterpolateConstraintsTest, StandardRuleIsTheOracles) {
  const std::uint32_t level = mesh_.corner_count() > 300 ? 1 : 2;
  ExpectIsTheOracles(mesh_, {.rule = FirstRule::kStandard, .level = level},
                     {.standard_rule = true});
}

TEST_P(InterpolateConstraintsTest, StandardRuleTakesAtMost28ChebyshevSweepsTo1e12) {
  const InterpolateResult result =
      InterpolateOrDie(mesh_, {.rule = FirstRule::kStandard, .surface = false});
  EXPECT_TRUE(result.solve.converged);
  EXPECT_LE(result.solve.sweeps, 28U);
  EXPECT_LE(result.solve.residual, 1e-12);
}

LIMN_FOR_CLOSED_MESHES(InterpolateConstraintsTest);

// The planar test meshes with boundary vertices of 1 to 6 faces.
TEST(InterpolateOpen, PlanarMeshesStayPlanarAndUnfolded) {
  for (const std::string name :
       {"Triangle", "Quad", "Octagon", "TwoQuads", "QuadPatch4x3", "QuadPatchJittered",
        "TriangleFan3", "TriangleFan7", "HalfFan2", "HalfFan3", "HalfFan6", "Ell", "Strip"}) {
    SCOPED_TRACE(name);
    PolygonMesh mesh = oracle::OpenMesh(name);
    for (Vec3& p : mesh.positions) p.z = 0;
    const Tessellation surface = InterpolateOrDie(mesh, {.level = 4}).surface;
    for (const Vec3& p : surface.positions) ASSERT_EQ(p.z, 0);
    for (const Vec3& n : surface.normals) ASSERT_LE(MaxAbs(n - Vec3{0, 0, 1}), 1e-15);
    for (std::size_t f = 0; f < surface.face_count(); ++f) {
      const auto p = [&](std::size_t i) {
        return surface.positions[surface.face_vertices[4 * f + i]];
      };
      ASSERT_GT(Cross(p(2) - p(0), p(3) - p(1)).z, 0) << f;
    }
  }
}

// The limit curve's tangents from both sides of each inner boundary vertex are the same line.
TEST(InterpolateOpen, BoundaryHasNoKinkForAnyNumberOfFaces) {
  for (int n = 2; n <= 9; ++n) {
    const Tessellation surface = InterpolateOrDie(oracle::HalfFan(n), {.level = 8}).surface;
    // Vertex 0 has n faces; its neighbours along the boundary at the finest level:
    std::vector<Vec3> directions;
    for (std::size_t f = 0; f < surface.face_count(); ++f) {
      for (std::size_t i = 0; i < 4; ++i) {
        if (surface.face_vertices[4 * f + i] != 0) continue;
        directions.push_back(surface.positions[surface.face_vertices[4 * f + (i + 1) % 4]] -
                             surface.positions[0]);
        directions.push_back(surface.positions[surface.face_vertices[4 * f + (i + 3) % 4]] -
                             surface.positions[0]);
      }
    }
    ASSERT_EQ(directions.size(), 2U * static_cast<std::size_t>(n));
    // The two along the boundary occur once, in opposite directions: some pair is straight.
    double straightest = 1;
    for (const Vec3& a : directions) {
      for (const Vec3& b : directions) {
        straightest = std::min(straightest, Dot(a, b) / (Norm(a) * Norm(b)));
      }
    }
    EXPECT_LE(straightest, -1 + 1e-4) << n;
  }
}

TEST(InterpolateOpen, EstimateIsAnUpperBoundWithinAFactorOfTwo) {
  // Many triangles apart have as much boundary as can be.
  PolygonMesh soup;
  for (Index t = 0; t < 20000 / oracle::kSlowdown; ++t) {
    for (int i = 0; i < 3; ++i) {
      soup.positions.push_back({1.0 * t, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0});
    }
    soup.AddFace({3 * t, 3 * t + 1, 3 * t + 2});
  }
  std::vector<PolygonMesh> meshes = {soup};
  for (const MeshKind kind : {MeshKind::kGrid, MeshKind::kDisk}) {
    LIMN_ASSERT_OK_AND_ASSIGN(
        PolygonMesh mesh,
        GenerateMesh({.kind = kind, .vertices = 30000 / oracle::kSlowdown, .seed = 1}));
    meshes.push_back(std::move(mesh));
  }
  for (const PolygonMesh& mesh : meshes) {
    const std::size_t boundary = oracle::BuildOrDie(mesh).boundary_edge_count();
    Constraints constraints = {.interpolate = std::vector<Index>{}};
    for (Index v = 0; v < mesh.vertex_count(); v += 2) {
      constraints.interpolate->push_back(v);
      constraints.normals.push_back({v, {0, 0, 1}});
    }
    const InterpolateOptions cases[] = {
        {.level = 0},
        {.level = 3},
        {.level = 2, .keep_patches = true},
        {.surface = false, .keep_patches = true},
        {.fair = true, .level = 1},
        {.rule = FirstRule::kStandard, .solve = {.method = SolveMethod::kJacobi}, .surface = false},
        {.rule = FirstRule::kStandard, .constraints = constraints, .level = 1}};
    for (const InterpolateOptions& options : cases) {
      const AllocationMeter meter;
      const InterpolateResult result = InterpolateOrDie(mesh, options);
      const std::uint64_t estimate = EstimateBytes(mesh.vertex_count(), mesh.face_count(),
                                                   mesh.corner_count(), options, boundary);
      EXPECT_LE(meter.peak(), estimate);
      EXPECT_GE(2 * meter.peak(), estimate);
    }
  }
}

TEST(InterpolateOpen, CornersAreMetEvenWhereTheyAreNotInterpolated) {
  const PolygonMesh mesh = oracle::QuadPatch(3, 2);
  const InterpolateResult result =
      InterpolateOrDie(mesh, {.constraints = {.interpolate = std::vector<Index>{}}, .level = 2});
  for (const Index corner : {0U, 3U, 8U, 11U}) {
    EXPECT_EQ(result.surface.positions[corner], mesh.positions[corner]);
  }
  // Nothing else was asked for: the given points are the control points.
  EXPECT_TRUE(result.control_positions == mesh.positions);
}

TEST(InterpolateConstraints, FairingKeepsPointsNormalsAndBoundariesAndNeverRaisesTheEnergy) {
  for (const std::string name :
       {"QuadPatchJittered", "CubeWithoutLid", "TorusOfTrianglesWithHole"}) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = oracle::OpenMesh(name);
    InterpolateOptions options = {
        .constraints = {.normals = {{1, {0.3, 0.2, 1}}}, .shape_handles = {{2, 0.5}}}, .level = 2};
    const InterpolateResult plain = InterpolateOrDie(mesh, options);
    EXPECT_FALSE(plain.fairness.has_value());
    options.fair = true;
    const InterpolateResult fair = InterpolateOrDie(mesh, options);
    ASSERT_TRUE(fair.fairness.has_value());
    EXPECT_LE(fair.fairness->energy_after, fair.fairness->energy_before);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      EXPECT_LE(Norm(fair.surface.positions[v] - mesh.positions[v]), 1e-13) << v;
    }
    EXPECT_LE(Norm(Cross(fair.surface.normals[1], NormalizedOrZero({0.3, 0.2, 1}))), 1e-10);
    EXPECT_EQ(BoundaryPoints(fair.surface), BoundaryPoints(plain.surface));
  }
}

TEST(InterpolateConstraints, OppositeNormalsGiveTheSameBits) {
  for (const std::string name : {"QuadPatch4x3", "CubeWithoutLid", "HalfFan6", "Strip"}) {
    const PolygonMesh mesh = oracle::OpenMesh(name);
    const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
    for (const Vec3& n : {Vec3{0.3, -1, 2}, Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{-4e-9, 1e-9, 0}}) {
      InterpolateOptions plus = {.level = 2};
      InterpolateOptions minus = {.level = 2};
      for (Index v = 0; v < mesh.vertex_count(); ++v) {
        plus.constraints.normals.push_back({v, n});
        minus.constraints.normals.push_back({v, -n});
      }
      EXPECT_TRUE(InterpolateOrDie(mesh, plus).surface.positions ==
                  InterpolateOrDie(mesh, minus).surface.positions)
          << name;
    }
  }
}

// A plane grid whose prescribed normals lie in it: its faces would collapse to lines.
TEST(InterpolateConstraints, NormalsInThePlaneOfTheFaceTurnIt) {
  PolygonMesh mesh = oracle::QuadPatch(4, 4);
  for (Vec3& p : mesh.positions) p.z = 0;
  for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{0.6, -0.8, 0}, Vec3{0, 1, 1e-5}}) {
    const InterpolateResult result =
        InterpolateOrDie(mesh, {.constraints = {.normals = {{12, n}}}, .level = 2});
    EXPECT_LE(Norm(Cross(result.surface.normals[12], n)), 1e-10);
    EXPECT_NEAR(Norm(result.surface.normals[12]), 1, 1e-12);
    EXPECT_LE(Norm(result.surface.positions[12] - mesh.positions[12]), 1e-14);
  }
}

// All points on a line: whatever normal is asked for, the result is finite, meets the points, and
// has no normal of its own.
TEST(InterpolateConstraints, FacesWithoutAreaHaveNoNormal) {
  PolygonMesh mesh = oracle::Cube();
  for (Vec3& p : mesh.positions) p = {p.x + 2 * p.y + 4 * p.z, 0, 0};
  for (const Vec3& n : {Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {
    const InterpolateResult result = InterpolateOrDie(
        mesh, {.constraints = {.normals = {{3, n}}, .shape_handles = {{3, 2.0}}}, .level = 2});
    for (const Vec3& p : result.surface.positions) ASSERT_TRUE(IsFinite(p));
    EXPECT_LE(Norm(result.surface.positions[3] - mesh.positions[3]), 1e-13);
    EXPECT_EQ(result.surface.normals[3], (Vec3{0, 0, 0}));
  }
}

// Brunet: the surface keeps point and normal, and nears the tangent plane as the handle grows.
TEST(InterpolateConstraints, HandlesKeepPointAndNormalAndFlatten) {
  const PolygonMesh mesh = oracle::Jittered(oracle::Cube(), 4, 0.1);
  const InterpolateResult plain = InterpolateOrDie(mesh, {.level = 3});
  std::vector<double> heights;
  for (const double value : {0.4, 1.0, 2.5}) {
    const InterpolateResult result =
        InterpolateOrDie(mesh, {.constraints = {.shape_handles = {{5, value}}}, .level = 3});
    EXPECT_LE(Norm(result.surface.positions[5] - mesh.positions[5]), 1e-14);
    EXPECT_LE(Norm(Cross(result.surface.normals[5], plain.surface.normals[5])), 1e-12);
    if (value == 1.0) {
      EXPECT_TRUE(result.surface.positions == plain.surface.positions);
    }
    // Height over the tangent plane per squared distance of the nearest points: the curvature.
    double height = 0;
    for (std::size_t f = 0; f < result.surface.face_count(); ++f) {
      const Index* q = &result.surface.face_vertices[4 * f];
      if (q[0] != 5) continue;
      const Vec3 d = result.surface.positions[q[2]] - result.surface.positions[5];
      height = std::max(height, std::fabs(Dot(d, result.surface.normals[5])) / Dot(d, d));
    }
    heights.push_back(height);
  }
  EXPECT_GT(heights[0], heights[1]);
  EXPECT_GT(heights[1], heights[2]);
}

// A move of a thousand diagonals costs three digits, of a million six: less than is promised.
TEST(InterpolateConstraints, JacobiThatGoesFarAstrayIsRefusedByDefault) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                            GenerateMesh({.kind = MeshKind::kNgons, .vertices = 11540, .seed = 1}));
  const auto result = Interpolate(
      Context(), mesh,
      {.rule = FirstRule::kStandard, .solve = {.method = SolveMethod::kJacobi}, .level = 0});
  oracle::ExpectError(result.status(), {Reason::kInvalidOption, "solve.method"});
}

// Whatever handles are accepted, points and normals keep their digits.
TEST(InterpolateConstraints, PointsAndNormalsAreMetWithHandlesAtBothEndsOfTheirRange) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh, GenerateMesh({.vertices = 200, .seed = 3}));
  const Real size = oracle::Diagonal(oracle::FromVec3(mesh.positions));
  for (const double handle : {kLeastHandle, 0.03, 30.0, kLargestHandle}) {
    SCOPED_TRACE(handle);
    InterpolateOptions options = {.level = 2};
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      options.constraints.shape_handles.push_back({v, handle});
      if (v % 2 == 0) options.constraints.normals.push_back({v, mesh.positions[v]});
    }
    const InterpolateResult result = InterpolateOrDie(mesh, options);
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      ASSERT_LE(ErrorAt(mesh, result, v), 1e-12 * size) << v;
    }
    for (const NormalConstraint& wish : options.constraints.normals) {
      const Vec3 n = result.surface.normals[wish.vertex];
      ASSERT_LE(Norm(Cross(n, wish.normal)) / Norm(wish.normal), 1e-10) << wish.vertex;
    }
  }
}

TEST(InterpolateConstraints, NormalsInsideAtVerticesOfTwoFacesAreRefusedByTheirField) {
  const PolygonMesh mesh = oracle::CubeWithVertexOfValenceTwo();
  Index two = kNoIndex;
  const std::vector<int> faces = oracle::FacesAround(oracle::FromPolygonMesh(mesh));
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (faces[v] == 2) two = v;
  }
  ASSERT_NE(two, kNoIndex);
  const Index other = two == 0 ? 1 : 0;
  const auto run = [&](const std::vector<NormalConstraint>& normals) {
    return Interpolate(Context(), mesh, {.constraints = {.normals = normals}});
  };
  oracle::ExpectError(run({{other, {0, 0, 1}}, {two, {0, 0, 1}}}).status(),
                      {Reason::kInvalidOption, "constraints.normals[1].vertex", 1});
  EXPECT_TRUE(run({{other, {0, 0, 1}}}).ok());
  // On a boundary two faces are enough: the curve has points there too.
  const PolygonMesh open = oracle::HalfFan(2);
  EXPECT_TRUE(Interpolate(Context(), open, {.constraints = {.normals = {{0, {0, 0, 1}}}}}).ok());
}

TEST(InterpolateConstraints, JacobiThatDivergesIsRefusedWithARemedy) {
  // Undamped Jacobi has the factor 1 - 4m / (m + 5) at the highest frequencies of an m-gon.
  const auto result = Interpolate(Context(), oracle::Jittered(oracle::Pillow(40), 1, 0.3),
                                  {.rule = FirstRule::kStandard,
                                   .solve = {.method = SolveMethod::kJacobi, .max_sweeps = 10000}});
  oracle::ExpectError(result.status(), {Reason::kInvalidOption, "solve.method"});
}

TEST(InterpolateConstraints, GaussSeidelSolvesTheStandardRuleToo) {
  const PolygonMesh mesh = oracle::Jittered(oracle::Prism(7), 1, 0.1);
  const auto control = [&](SolveMethod method) {
    return InterpolateOrDie(mesh, {.rule = FirstRule::kStandard,
                                   .solve = {.method = method, .max_sweeps = 1000},
                                   .surface = false})
        .control_positions;
  };
  const Buffer<Vec3> a = control(SolveMethod::kChebyshev);
  const Buffer<Vec3> b = control(SolveMethod::kGaussSeidel);
  for (std::size_t v = 0; v < a.size(); ++v) EXPECT_LE(Norm(a[v] - b[v]), 1e-10) << v;
}

TEST(InterpolateConstraints, AreCheckedBeforeTheyAreUsed) {
  oracle::ExpectError(
      Interpolate(Context(), oracle::Cube(), {.constraints = {.shape_handles = {{8, 1.0}}}})
          .status(),
      {Reason::kIndexOutOfRange, "constraints.shape_handles[0].vertex", 0});
}

}  // namespace
}  // namespace limn
