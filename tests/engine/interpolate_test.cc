// SPDX-License-Identifier: MIT
// The guarantees of the whole job. Limits, memory and stopping: interpolate_limits_test.cc.
#include "engine/interpolate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"

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

// Largest distance of the surface's first vertices from the given ones, over the box's diagonal
// (over 1 where that is 0).
Real InterpolationError(const PolygonMesh& mesh, const InterpolateResult& result) {
  const Points given = oracle::FromVec3(mesh.positions);
  Points surface = oracle::FromVec3(result.surface.positions);
  if (surface.size() < given.size()) return std::numeric_limits<Real>::infinity();
  surface.resize(given.size());
  const Real size = oracle::Diagonal(given);
  return oracle::MaxDistance(surface, given) / (size > 0 ? size : 1);
}

std::vector<oracle::Face> FacesOf(const Tessellation& surface) {
  std::vector<oracle::Face> faces;
  for (std::size_t f = 0; f < surface.face_count(); ++f) {
    const std::size_t begin = surface.arity == 0 ? surface.face_begin[f] : f * surface.arity;
    const std::size_t end = surface.arity == 0 ? surface.face_begin[f + 1] : begin + surface.arity;
    oracle::Face face;
    for (std::size_t i = begin; i < end; ++i) {
      face.push_back(static_cast<int>(surface.face_vertices[i]));
    }
    faces.push_back(face);
  }
  return faces;
}

void ExpectSameBits(const InterpolateResult& a, const InterpolateResult& b) {
  EXPECT_TRUE(a.control_positions == b.control_positions);
  EXPECT_TRUE(a.surface.positions == b.surface.positions);
  EXPECT_TRUE(a.surface.normals == b.surface.normals);
  EXPECT_TRUE(a.surface.face_vertices == b.surface.face_vertices);
  EXPECT_EQ(a.solve.sweeps, b.solve.sweeps);
  EXPECT_EQ(a.solve.residual, b.solve.residual);
}

class InterpolateTest : public oracle::ClosedMeshTest {};

TEST_P(InterpolateTest, FirstVerticesAreTheGivenPointsWhateverTheSolve) {
  std::vector<SolveOptions> solves;
  for (const SolveMethod method :
       {SolveMethod::kChebyshev, SolveMethod::kJacobi, SolveMethod::kGaussSeidel}) {
    for (const double tolerance : {1e-1, 1e-3, 1e-12}) {
      solves.push_back({.method = method, .tolerance = tolerance});
    }
    for (const std::uint32_t sweeps : {0U, 2U}) {
      solves.push_back({.method = method, .tolerance = 0, .max_sweeps = sweeps});
    }
  }
  for (const SolveOptions& solve : solves) {
    for (const std::uint32_t level : {0U, 1U, 3U}) {
      SCOPED_TRACE(absl::StrCat("method ", static_cast<int>(solve.method), ", tolerance ",
                                solve.tolerance, ", level ", level));
      const InterpolateResult result = InterpolateOrDie(mesh_, {.solve = solve, .level = level});
      EXPECT_LE(InterpolationError(mesh_, result), 1e-12);
    }
  }
}

TEST_P(InterpolateTest, ControlMeshIsTheDenseSolutionInTheInputsOrder) {
  const InterpolateResult result = InterpolateOrDie(mesh_, {.surface = false});
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.control_positions),
                                oracle::SolveEquation6(given_)),
            1e-12 * oracle::Diagonal(given_.points));
  EXPECT_EQ(result.surface.vertex_count(), 0U);
  EXPECT_EQ(result.surface.face_count(), 0U);
}

TEST_P(InterpolateTest, SurfaceIsTheOraclesAtEveryLevel) {
  for (const std::uint32_t level : {1U, 2U, 3U}) {
    if (level == 3 && mesh_.corner_count() > 500) break;
    SCOPED_TRACE(level);
    const InterpolateResult result = InterpolateOrDie(mesh_, {.level = level});
    const oracle::Interpolated expected = oracle::InterpolateDooSabin(
        given_, oracle::FromVec3(result.control_positions), static_cast<int>(level));
    const Real size = oracle::Diagonal(given_.points);
    EXPECT_EQ(result.surface.level, level);
    EXPECT_EQ(result.surface.arity, 4U);
    ASSERT_EQ(FacesOf(result.surface), expected.tiling.faces);
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.surface.positions), expected.points),
              1e-13 * size);
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.surface.normals), expected.normals),
              1e-9);
  }
}

TEST_P(InterpolateTest, LevelZeroHasTheInputsFaces) {
  const InterpolateResult result = InterpolateOrDie(mesh_, {.level = 0});
  EXPECT_EQ(FacesOf(result.surface), given_.faces);
  EXPECT_EQ(result.surface.vertex_count(), mesh_.vertex_count());
  EXPECT_EQ(result.surface.normals.size(), mesh_.vertex_count());
  EXPECT_EQ(result.surface.level, 0U);
}

TEST_P(InterpolateTest, EveryLevelHasTheEulerCharacteristicOfTheInput) {
  const int euler = oracle::EulerCharacteristic(oracle::TilingOf(given_));
  for (const std::uint32_t level : {0U, 1U, 2U, 3U}) {
    const InterpolateResult result = InterpolateOrDie(mesh_, {.level = level});
    EXPECT_EQ(oracle::EulerCharacteristic(
                  {static_cast<int>(result.surface.vertex_count()), FacesOf(result.surface)}),
              euler)
        << level;
  }
}

// Refinement finds more points of the same surface: those of a level stay, and so do their normals.
TEST_P(InterpolateTest, PointsOfALevelAreThePointsOfTheNext) {
  const double size = static_cast<double>(oracle::Diagonal(given_.points));
  InterpolateResult coarse = InterpolateOrDie(mesh_, {.level = 0});
  for (std::uint32_t level = 1; level <= 4; ++level) {
    InterpolateResult fine = InterpolateOrDie(mesh_, {.level = level});
    ASSERT_GT(fine.surface.vertex_count(), coarse.surface.vertex_count());
    for (std::size_t v = 0; v < coarse.surface.vertex_count(); ++v) {
      ASSERT_LE(MaxAbs(fine.surface.positions[v] - coarse.surface.positions[v]), 1e-14 * size);
      ASSERT_LE(MaxAbs(fine.surface.normals[v] - coarse.surface.normals[v]), 1e-9);
    }
    coarse = std::move(fine);
  }
}

// Differences to neighbours, level after level, turn into the tangent plane.
TEST_P(InterpolateTest, NormalsAreThoseOfTheSurfaceAroundThem) {
  const auto largest_slope = [&](const Tessellation& surface, std::size_t vertices) {
    std::vector<double> slope(vertices, 0);
    for (std::size_t q = 0; q < surface.face_count(); ++q) {
      const Index* const quad = &surface.face_vertices[4 * q];
      if (quad[0] >= vertices) continue;
      for (const std::size_t i : {1, 2, 3}) {
        const Vec3 edge = surface.positions[quad[i]] - surface.positions[quad[0]];
        slope[quad[0]] = std::max(slope[quad[0]],
                                  std::abs(Dot(NormalizedOrZero(edge), surface.normals[quad[0]])));
      }
    }
    return slope;
  };
  const std::size_t n = mesh_.vertex_count();
  const std::vector<double> near = largest_slope(InterpolateOrDie(mesh_, {.level = 3}).surface, n);
  const std::vector<double> nearer =
      largest_slope(InterpolateOrDie(mesh_, {.level = 6}).surface, n);
  for (std::size_t v = 0; v < n; ++v) {
    // Three refinements halve distances three times; the slope falls by 8 in the long run.
    EXPECT_LE(nearer[v], 0.3 * near[v] + 1e-9) << v;
  }
}

TEST_P(InterpolateTest, NormalsAreUnitVectorsOrZero) {
  const InterpolateResult result = InterpolateOrDie(mesh_, {.level = 2});
  ASSERT_EQ(result.surface.normals.size(), result.surface.vertex_count());
  for (const Vec3& normal : result.surface.normals) {
    if (normal == Vec3{0, 0, 0}) continue;
    EXPECT_NEAR(Norm(normal), 1, 1e-14);
  }
}

TEST_P(InterpolateTest, NormalsAreLeftOutOnRequestAndChangeNothingElse) {
  const InterpolateResult with = InterpolateOrDie(mesh_, {});
  const InterpolateResult without = InterpolateOrDie(mesh_, {.normals = false});
  EXPECT_TRUE(without.surface.normals.empty());
  EXPECT_TRUE(with.surface.positions == without.surface.positions);
  EXPECT_TRUE(with.surface.face_vertices == without.surface.face_vertices);
}

Vec3 Apply(const std::array<Vec3, 3>& rows, const Vec3& p) {
  return {Dot(rows[0], p), Dot(rows[1], p), Dot(rows[2], p)};
}

TEST_P(InterpolateTest, ControlMeshMovesWithAffineMapsOfTheInput) {
  const std::array<Vec3, 3> rows = {Vec3{2, 0.5, -0.25}, Vec3{-0.5, 1, 0.75}, Vec3{0.25, 0, 3}};
  const Vec3 offset = {5, -7, 1};
  PolygonMesh mapped = mesh_;
  for (Vec3& p : mapped.positions) p = Apply(rows, p) + offset;
  Points expected = oracle::FromVec3(InterpolateOrDie(mesh_, {.surface = false}).control_positions);
  for (oracle::Point& p : expected) {
    const Vec3 q =
        Apply(rows, {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
    p = oracle::FromVec3({q + offset})[0];
  }
  const InterpolateResult result = InterpolateOrDie(mapped, {.surface = false});
  EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(result.control_positions), expected),
            2e-12 * oracle::Diagonal(oracle::FromVec3(mapped.positions)));
}

// Angles enter with the planes of the perturbation, so the surface moves with similarities only.
TEST_P(InterpolateTest, SurfaceMovesWithSimilaritiesOfTheInput) {
  // A rotation.
  const std::array<Vec3, 3> rows = {Vec3{2. / 3, -1. / 3, 2. / 3}, Vec3{2. / 3, 2. / 3, -1. / 3},
                                    Vec3{-1. / 3, 2. / 3, 2. / 3}};
  const Vec3 offset = {5, -7, 1};
  PolygonMesh mapped = mesh_;
  for (Vec3& p : mapped.positions) p = 2.5 * Apply(rows, p) + offset;
  const InterpolateResult before = InterpolateOrDie(mesh_);
  const InterpolateResult after = InterpolateOrDie(mapped);
  const double size = static_cast<double>(oracle::Diagonal(oracle::FromVec3(mapped.positions)));
  ASSERT_EQ(before.surface.vertex_count(), after.surface.vertex_count());
  for (std::size_t v = 0; v < before.surface.vertex_count(); ++v) {
    const Vec3 expected = 2.5 * Apply(rows, before.surface.positions[v]) + offset;
    ASSERT_LE(MaxAbs(after.surface.positions[v] - expected), 5e-12 * size);
    ASSERT_LE(MaxAbs(after.surface.normals[v] - Apply(rows, before.surface.normals[v])), 1e-7);
  }
}

LIMN_FOR_CLOSED_MESHES(InterpolateTest);

TEST(Interpolate, ConvexMeshesHaveNormalsThatPointOutwards) {
  for (const char* const name : {"tetrahedron", "cube", "octahedron", "dodecahedron", "prism_40",
                                 "antiprism_5", "double_pyramid_200"}) {
    SCOPED_TRACE(name);
    const InterpolateResult result = InterpolateOrDie(oracle::ClosedMesh(name), {.level = 3});
    Vec3 center = {0, 0, 0};
    for (const Vec3& p : result.surface.positions) center += p;
    center *= 1.0 / static_cast<double>(result.surface.vertex_count());
    for (std::size_t v = 0; v < result.surface.vertex_count(); ++v) {
      ASSERT_GT(Dot(result.surface.normals[v], result.surface.positions[v] - center), 0) << v;
    }
  }
}

TEST(Interpolate, ADodecahedronComesCloseToItsSphere) {
  const InterpolateResult result = InterpolateOrDie(oracle::Dodecahedron(), {.level = 3});
  for (std::size_t v = 0; v < result.surface.vertex_count(); ++v) {
    const Vec3& p = result.surface.positions[v];
    EXPECT_NEAR(Norm(p) / std::sqrt(3.0), 1, 0.08);
    EXPECT_LE(Norm(NormalizedOrZero(p) - result.surface.normals[v]), 0.2);
  }
}

// At the vertices of regular solids the normal is the axis.
TEST(Interpolate, RegularSolidsHaveNormalsAlongTheAxesOfTheirVertices) {
  for (const char* const name : {"tetrahedron", "cube", "octahedron", "dodecahedron"}) {
    PolygonMesh mesh = oracle::ClosedMesh(name);
    Vec3 center = {0, 0, 0};
    for (const Vec3& p : mesh.positions) center += p;
    center *= 1.0 / static_cast<double>(mesh.vertex_count());
    const InterpolateResult result = InterpolateOrDie(mesh);
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      const Vec3 axis = NormalizedOrZero(mesh.positions[v] - center);
      EXPECT_LE(MaxAbs(result.surface.normals[v] - axis), 1e-12) << name;
    }
  }
}

TEST(Interpolate, HasTheSameBitsForAnyNumberOfThreads) {
  for (const MeshKind kind : {MeshKind::kIrregularSphere, MeshKind::kHub}) {
    LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                              GenerateMesh({.kind = kind, .vertices = 20000, .seed = 5}));
    for (const SolveMethod method :
         {SolveMethod::kChebyshev, SolveMethod::kJacobi, SolveMethod::kGaussSeidel}) {
      const auto run = [&](int threads) {
        return oracle::WithThreads(threads, [&] {
          return InterpolateOrDie(mesh, {.solve = {.method = method, .tolerance = 1e-6}});
        });
      };
      const InterpolateResult one = run(1);
      EXPECT_LE(InterpolationError(mesh, one), 1e-12);
      ExpectSameBits(one, run(2));
      ExpectSameBits(one, run(5));
    }
  }
}

TEST(Interpolate, CoincidentPointsGiveThatPointWithoutNormals) {
  for (const Vec3& point : {Vec3{0, 0, 0}, Vec3{1, 2, 3}, Vec3{0.1, -1e10, 1e-10}}) {
    PolygonMesh mesh = oracle::Dodecahedron();
    for (Vec3& p : mesh.positions) p = point;
    const InterpolateResult result = InterpolateOrDie(mesh);
    EXPECT_TRUE(result.solve.converged);
    for (std::size_t v = 0; v < result.surface.vertex_count(); ++v) {
      EXPECT_EQ(result.surface.positions[v], point);
      EXPECT_EQ(result.surface.normals[v], (Vec3{0, 0, 0}));
    }
  }
}

TEST(Interpolate, FlatAndLineShapedMeshesWork) {
  PolygonMesh flat = oracle::Jittered(oracle::Prism(7), 2, 0.3);
  PolygonMesh line = flat;
  for (Vec3& p : flat.positions) p.z = 0.5;
  for (Vec3& p : line.positions) p = {p.x, 2 * p.x, 1 - p.x};
  const InterpolateResult flat_result = InterpolateOrDie(flat);
  EXPECT_LE(InterpolationError(flat, flat_result), 1e-12);
  for (const Vec3& p : flat_result.surface.positions) EXPECT_NEAR(p.z, 0.5, 1e-13);
  const InterpolateResult line_result = InterpolateOrDie(line);
  EXPECT_LE(InterpolationError(line, line_result), 1e-12);
  for (const Vec3& p : line_result.surface.positions) {
    EXPECT_NEAR(p.y, 2 * p.x, 1e-12);
    EXPECT_NEAR(p.z, 1 - p.x, 1e-12);
  }
  for (const Vec3& normal : line_result.surface.normals) EXPECT_EQ(normal, (Vec3{0, 0, 0}));
}

// All that is done is linear but for unit vectors: powers of two change no bit of them.
TEST(Interpolate, WorksAtEverySizeToRelativeAccuracy) {
  const PolygonMesh mesh = oracle::ClosedMesh("irregular_sphere_seed_1");
  const InterpolateResult unit = InterpolateOrDie(mesh);
  for (const double size : {1e-300, 1e-200, 1e-100, 1e-6, 1e6, 1e50, 1e90, 1e99}) {
    SCOPED_TRACE(size);
    const PolygonMesh scaled = oracle::Moved(mesh, size, {0, 0, 0});
    const InterpolateResult result = InterpolateOrDie(scaled);
    EXPECT_LE(InterpolationError(scaled, result), 1e-12);
    EXPECT_TRUE(result.solve.converged);
    EXPECT_LE(result.solve.sweeps, 18U);
    EXPECT_NEAR(result.solve.residual, unit.solve.residual, 1e-14);
    ASSERT_EQ(result.surface.vertex_count(), unit.surface.vertex_count());
    for (std::size_t v = 0; v < unit.surface.vertex_count(); ++v) {
      ASSERT_LE(MaxAbs(result.surface.positions[v] - size * unit.surface.positions[v]),
                1e-11 * size);
      ASSERT_LE(MaxAbs(result.surface.normals[v] - unit.surface.normals[v]), 1e-7);
    }
  }
}

// Below, what is left of differences could not hold the guarantee.
TEST(Interpolate, MeshesOfDenormalExtentAreRefusedAndThoseAboveAreMet) {
  const PolygonMesh cube = oracle::Jittered(oracle::Cube(), 1, 0.3);
  for (const double scale : {1e-323, 1e-318, 1e-310, 1e-301}) {
    oracle::ExpectError(Interpolate(Context(), oracle::Moved(cube, scale, {})).status(),
                        {Reason::kExtentTooSmall, "mesh.vertices"});
  }
  for (const double scale : {1e-299, 1e-200}) {
    const PolygonMesh mesh = oracle::Moved(cube, scale, {});
    EXPECT_LE(InterpolationError(mesh, InterpolateOrDie(mesh)), 1e-12);
  }
  // Denormal coordinates beside ordinary ones are ordinary small numbers.
  PolygonMesh mixed = cube;
  mixed.positions[0].x = 1e-310;
  EXPECT_LE(InterpolationError(mixed, InterpolateOrDie(mixed)), 1e-12);
}

// Georeferenced models: the box is small and far from the origin.
TEST(Interpolate, WorksFarFromTheOriginToTheAccuracyOfTheCoordinates) {
  const PolygonMesh mesh = oracle::ClosedMesh("irregular_sphere_seed_1");
  const InterpolateResult near = InterpolateOrDie(mesh);
  for (const double away : {1e3, 5e5, 1e8}) {
    SCOPED_TRACE(away);
    const Vec3 offset = {away, -away, 0.5 * away};
    const PolygonMesh moved = oracle::Moved(mesh, 1, offset);
    const InterpolateResult result = InterpolateOrDie(moved);
    EXPECT_LE(InterpolationError(moved, result), 1e-12);
    EXPECT_TRUE(result.solve.converged);
    EXPECT_LE(result.solve.sweeps, 18U);
    for (std::size_t v = 0; v < near.surface.vertex_count(); ++v) {
      // The input itself was rounded when it was moved.
      ASSERT_LE(MaxAbs(result.surface.positions[v] - offset - near.surface.positions[v]),
                4e-15 * away + 1e-11);
    }
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
      ASSERT_LE(MaxAbs(result.control_positions[v] - offset - near.control_positions[v]),
                4e-15 * away + 1e-11);
    }
  }
}

TEST(Interpolate, HubsOfValence20000AreInterpolated) {
  const PolygonMesh mesh = oracle::DoublePyramid(20000);
  const auto begin = Context::Clock::now();
  const InterpolateResult result = InterpolateOrDie(mesh, {.level = 3});
  EXPECT_LE(InterpolationError(mesh, result), 1e-12);
  // Quadratic work at the hub would take minutes.
  EXPECT_LT(Context::Clock::now() - begin, std::chrono::seconds(20));
}

TEST(Interpolate, LargeMeshesOfEveryKindAreInterpolated) {
  for (const MeshKind kind : AllMeshKinds()) {
    if (!IsClosedKind(kind)) continue;
    SCOPED_TRACE(std::string(MeshKindName(kind)));
    LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                              GenerateMesh({.kind = kind, .vertices = 11540, .seed = 3}));
    const InterpolateResult result =
        InterpolateOrDie(mesh, {.solve = {.tolerance = 3e-3, .max_sweeps = 5}});
    EXPECT_LE(InterpolationError(mesh, result), 1e-12);
  }
}

TEST(Interpolate, DefaultsAreThoseOfTheContract) {
  const InterpolateOptions options;
  EXPECT_EQ(options.scheme, Scheme::kDooSabin);
  EXPECT_EQ(options.level, 2U);
  EXPECT_TRUE(options.surface);
  EXPECT_TRUE(options.normals);
}

}  // namespace
}  // namespace limn
