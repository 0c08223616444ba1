// SPDX-License-Identifier: MIT
#include "engine/solve/solve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/validate.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/rotation_map.h"

namespace limn {
namespace {

using oracle::Points;
using oracle::Real;

constexpr SolveMethod kMethods[] = {SolveMethod::kChebyshev, SolveMethod::kJacobi,
                                    SolveMethod::kGaussSeidel, SolveMethod::kSeries,
                                    SolveMethod::kConjugateGradient};

struct Solution {
  SolveReport report;
  std::vector<Vec3> points;
};

double ScaleOf(const PolygonMesh& mesh) {
  BoundingBox box;
  EXPECT_TRUE(ValidatePositions(Context(), mesh.positions, &box).ok());
  return box.diagonal();
}

Solution SolveMesh(const PolygonMesh& mesh, const SolveOptions& options,
                   const Context& context = Context()) {
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  const LimitStencil stencil = DooSabinModifiedStencil();
  Solution solution;
  solution.points.resize(mesh.vertex_count());
  const auto report =
      Solve(context,
            {.mesh = built, .stencil = stencil, .points = mesh.positions, .scale = ScaleOf(mesh)},
            options, absl::MakeSpan(solution.points));
  EXPECT_TRUE(report.ok()) << report.status();
  if (report.ok()) solution.report = *report;
  return solution;
}

// I - L X by the oracle's Eq. 6.
Points Residual(const oracle::Mesh& given, const Points& x) {
  const oracle::Matrix matrix = oracle::Equation6(given);
  const std::vector<int> m = oracle::FacesAround(given);
  Points residual = given.points;
  for (std::size_t v = 0; v < x.size(); ++v) {
    for (std::size_t u = 0; u < x.size(); ++u) {
      residual[v] = residual[v] - (matrix[v][u] / (2 * m[v])) * x[u];
    }
  }
  return residual;
}

// sqrt(sum m_v |e_v|^2): the norm in which the operator is self-adjoint.
Real DNorm(const oracle::Mesh& given, const Points& a, const Points& b) {
  const std::vector<int> m = oracle::FacesAround(given);
  Real sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    sum += static_cast<Real>(m[v]) * oracle::Dot(a[v] - b[v], a[v] - b[v]);
  }
  return std::sqrt(sum);
}

class SolveTest : public oracle::ClosedMeshTest {};

TEST_P(SolveTest, EveryMethodFindsTheDenseSolution) {
  const Points dense = oracle::SolveEquation6(given_);
  const Real size = oracle::Diagonal(given_.points);
  for (const SolveMethod method : kMethods) {
    SCOPED_TRACE(static_cast<int>(method));
    const Solution solution = SolveMesh(mesh_, {.method = method, .tolerance = 1e-14});
    EXPECT_TRUE(solution.report.converged);
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(solution.points), dense), 1e-12 * size);
    EXPECT_EQ(solution.report.method, method);
  }
}

TEST_P(SolveTest, ChebyshevTakesAtMost18SweepsTo1e12) {
  const Solution solution = SolveMesh(mesh_, {});
  EXPECT_TRUE(solution.report.converged);
  EXPECT_LE(solution.report.sweeps, 18U);
  EXPECT_LE(solution.report.residual, 1e-12);
}

TEST_P(SolveTest, ErrorAfterKSweepsIsWithinTheChebyshevBound) {
  const Points dense = oracle::SolveEquation6(given_);
  const Real start = DNorm(given_, given_.points, dense);
  const Real size = oracle::Diagonal(given_.points);
  for (const std::uint32_t k : {1U, 2U, 5U, 9U, 12U}) {
    SCOPED_TRACE(k);
    const Solution solution = SolveMesh(mesh_, {.tolerance = 0, .max_sweeps = k});
    EXPECT_EQ(solution.report.sweeps, k);
    const Real error = DNorm(given_, oracle::FromVec3(solution.points), dense);
    // T_k(3) = cosh(k arcosh 3).
    const Real bound = start / std::cosh(k * std::acosh(3.0L));
    EXPECT_LE(error, bound * (1 + 1e-9L) + 1e-13L * size);
  }
}

TEST_P(SolveTest, SweepsOfJacobiAndGaussSeidelAreEquationSeven) {
  Points jacobi = given_.points;
  Points gauss_seidel = given_.points;
  const Real size = oracle::Diagonal(given_.points);
  for (std::uint32_t k = 1; k <= 3; ++k) {
    SCOPED_TRACE(k);
    jacobi = oracle::JacobiSweep(given_, jacobi);
    gauss_seidel = oracle::GaussSeidelSweep(given_, gauss_seidel);
    const auto run = [&](SolveMethod method) {
      return oracle::FromVec3(
          SolveMesh(mesh_, {.method = method, .tolerance = 0, .max_sweeps = k}).points);
    };
    EXPECT_LE(oracle::MaxDistance(run(SolveMethod::kJacobi), jacobi), 1e-14 * size);
    EXPECT_LE(oracle::MaxDistance(run(SolveMethod::kGaussSeidel), gauss_seidel), 1e-14 * size);
  }
}

TEST_P(SolveTest, ResidualIsTheTrueResidual) {
  const Real size = oracle::Diagonal(given_.points);
  for (const SolveMethod method : kMethods) {
    for (const std::uint32_t sweeps : {0U, 1U, 4U, 30U}) {
      SCOPED_TRACE(absl::StrCat(static_cast<int>(method), ", sweeps: ", sweeps));
      const Solution solution =
          SolveMesh(mesh_, {.method = method, .tolerance = 0, .max_sweeps = sweeps});
      Real largest = 0;
      for (const oracle::Point& r : Residual(given_, oracle::FromVec3(solution.points))) {
        largest = std::max(largest, oracle::Norm(r));
      }
      EXPECT_NEAR(solution.report.residual, static_cast<double>(largest / size), 1e-14);
    }
  }
}

TEST_P(SolveTest, StopsAtTheFirstSweepThatMovesLessThanTheTolerance) {
  for (const SolveMethod method : kMethods) {
    // These stop by the residual; see below.
    if (method == SolveMethod::kChebyshev) continue;
    if (method == SolveMethod::kConjugateGradient) continue;
    for (const double tolerance : {1e-1, 1e-3, 1e-7}) {
      SCOPED_TRACE(absl::StrCat(static_cast<int>(method), ", tolerance: ", tolerance));
      const Solution stopped = SolveMesh(mesh_, {.method = method, .tolerance = tolerance});
      ASSERT_TRUE(stopped.report.converged);
      ASSERT_GE(stopped.report.sweeps, 1U);
      EXPECT_LE(stopped.report.last_update, tolerance);
      const auto run = [&](std::uint32_t sweeps) {
        return SolveMesh(mesh_, {.method = method, .tolerance = 0, .max_sweeps = sweeps});
      };
      EXPECT_EQ(run(stopped.report.sweeps).points, stopped.points);
      if (stopped.report.sweeps > 1) {
        const Solution before = run(stopped.report.sweeps - 1);
        EXPECT_GT(before.report.last_update, tolerance);
        double move = 0;
        for (std::size_t v = 0; v < stopped.points.size(); ++v) {
          move = std::max(move, Norm(stopped.points[v] - before.points[v]));
        }
        EXPECT_NEAR(stopped.report.last_update, move / ScaleOf(mesh_), 1e-14);
      }
    }
  }
}

TEST_P(SolveTest, ChebyshevStopsByTheResidualThatASweepLeaves) {
  for (const double tolerance : {1e-1, 1e-3, 1e-7, 1e-12}) {
    SCOPED_TRACE(tolerance);
    const auto run = [&](double limit, std::uint32_t sweeps) {
      return SolveMesh(mesh_, {.tolerance = limit, .max_sweeps = sweeps});
    };
    const Solution stopped = run(tolerance, 100);
    ASSERT_TRUE(stopped.report.converged);
    // Twice the residual: no eigenvalue is below 1/2.
    EXPECT_LE(2 * stopped.report.residual, tolerance);
    EXPECT_EQ(stopped.report.last_update, 2 * stopped.report.residual);
    // It is the first one, but where a sweep did far better than it has to.
    if (stopped.report.sweeps == 1) continue;
    const double before = run(0, stopped.report.sweeps - 1).report.residual;
    if (2 * before <= tolerance && stopped.report.sweeps > 2) {
      EXPECT_GT(2 * run(0, stopped.report.sweeps - 2).report.residual, 6 * tolerance);
    }
  }
}

TEST_P(SolveTest, ConjugateGradientsStopAtTheFirstStepWhoseTrueResidualIsWithinTheTolerance) {
  for (const double tolerance : {1e-1, 1e-3, 1e-7}) {
    const auto run = [&](double limit, std::uint32_t steps) {
      return SolveMesh(
          mesh_,
          {.method = SolveMethod::kConjugateGradient, .tolerance = limit, .max_sweeps = steps});
    };
    const Solution stopped = run(tolerance, 100);
    ASSERT_TRUE(stopped.report.converged);
    EXPECT_LE(stopped.report.residual, tolerance);
    EXPECT_EQ(stopped.report.last_update, stopped.report.residual);
    if (stopped.report.sweeps == 0) continue;
    const Solution before = run(0, stopped.report.sweeps - 1);
    EXPECT_GT(before.report.residual, tolerance);
  }
}

// [ZC]'s operator has its spectrum in [1/2, 1], and the Lanczos process sees some of it.
TEST_P(SolveTest, ConjugateGradientsSeeNoEigenvalueBelowTheLeastOne) {
  const Solution solution = SolveMesh(mesh_, {.method = SolveMethod::kConjugateGradient});
  EXPECT_GE(solution.report.least_eigenvalue, 0.5 - 1e-6);
  EXPECT_LE(solution.report.least_eigenvalue, 1);
}

LIMN_FOR_CLOSED_MESHES(SolveTest);

TEST(Solve, ChebyshevTakesAtMost18SweepsOnLargeMeshesOfEveryKind) {
  for (const MeshKind kind : AllMeshKinds()) {
    if (!IsClosedKind(kind)) continue;
    for (const std::uint64_t seed : {1, 2, 3}) {
      SCOPED_TRACE(absl::StrCat(std::string(MeshKindName(kind)), ", seed: ", seed));
      LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                                GenerateMesh({.kind = kind, .vertices = 20000, .seed = seed}));
      const Solution solution = SolveMesh(mesh, {});
      EXPECT_TRUE(solution.report.converged);
      EXPECT_LE(solution.report.sweeps, 18U);
      EXPECT_LE(solution.report.residual, 1e-12);
    }
  }
}

// On this one sweeps leave 24 times as much in the worst point as on ordinary ones.
TEST(Solve, ChebyshevTakesAtMost18SweepsWhereValencesAritiesAndGenusAreLarge) {
  const PolygonMesh mesh = oracle::RotationMap();
  ASSERT_EQ(mesh.vertex_count(), 1892U);
  ASSERT_EQ(mesh.face_count(), 1892U);
  const Solution solution = SolveMesh(mesh, {});
  EXPECT_TRUE(solution.report.converged);
  EXPECT_LE(solution.report.sweeps, 18U);
  EXPECT_LE(solution.report.residual, 1e-12);
  // It is a bad one.
  EXPECT_GT(SolveMesh(mesh, {.tolerance = 0, .max_sweeps = 16}).report.residual, 2e-12);
}

TEST(Solve, ChebyshevTakesAtMost18SweepsAtAHubOfValence20000) {
  const Solution solution = SolveMesh(oracle::DoublePyramid(20000), {});
  EXPECT_TRUE(solution.report.converged);
  EXPECT_LE(solution.report.sweeps, 18U);
}

TEST(Solve, WithoutSweepsTheGivenPointsAreTheControlPoints) {
  const PolygonMesh mesh = oracle::Jittered(oracle::Cube(), 5, 0.3);
  for (const SolveMethod method : kMethods) {
    const Solution solution = SolveMesh(mesh, {.method = method, .max_sweeps = 0});
    EXPECT_EQ(absl::MakeConstSpan(solution.points), absl::MakeConstSpan(mesh.positions));
    EXPECT_EQ(solution.report.sweeps, 0U);
    EXPECT_FALSE(solution.report.converged);
    EXPECT_GT(solution.report.residual, 1e-3);
  }
}

TEST(Solve, NotMeetingTheToleranceIsNoError) {
  const Solution solution = SolveMesh(oracle::Cube(), {.tolerance = 1e-12, .max_sweeps = 3});
  EXPECT_FALSE(solution.report.converged);
  EXPECT_EQ(solution.report.sweeps, 3U);
  EXPECT_GT(solution.report.last_update, 1e-12);
}

TEST(Solve, DefaultsAreThoseOfTheContract) {
  const SolveOptions options;
  EXPECT_EQ(options.method, SolveMethod::kAutomatic);
  EXPECT_EQ(options.tolerance, 1e-12);
  EXPECT_EQ(options.max_sweeps, 100U);
}

TEST(Solve, RefusesTolerancesOutOfRange) {
  for (const double tolerance :
       {-1e-300, -1.0, 1.0, 2.0, std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    SCOPED_TRACE(tolerance);
    const SolveOptions options = {.tolerance = tolerance};
    oracle::ExpectError(ValidateSolveOptions(options), {Reason::kInvalidOption, "solve.tolerance"});
  }
  for (const double tolerance : {0.0, 1e-300, 0.999}) {
    EXPECT_TRUE(ValidateSolveOptions({.tolerance = tolerance}).ok()) << tolerance;
  }
}

TEST(Solve, RefusesMoreThan10000Sweeps) {
  EXPECT_TRUE(ValidateSolveOptions({.max_sweeps = 10000}).ok());
  for (const std::uint32_t sweeps : {10001U, ~0U}) {
    oracle::ExpectError(ValidateSolveOptions({.max_sweeps = sweeps}),
                        {Reason::kInvalidOption, "solve.max_sweeps"});
  }
}

TEST(Solve, ChecksItsOptionsBeforeItStarts) {
  const PolygonMesh mesh = oracle::Cube();
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  const LimitStencil stencil = DooSabinModifiedStencil();
  const Vec3 mark = {7, 7, 7};
  std::vector<Vec3> points(mesh.vertex_count(), mark);
  const auto report =
      Solve(Context(), {.mesh = built, .stencil = stencil, .points = mesh.positions},
            {.tolerance = -1}, absl::MakeSpan(points));
  oracle::ExpectError(report.status(), {Reason::kInvalidOption, "solve.tolerance"});
  EXPECT_EQ(points, std::vector<Vec3>(mesh.vertex_count(), mark));
}

TEST(Solve, ReportsEverySweepOnce) {
  Context context;
  std::vector<ProgressEvent> events;
  context.set_progress([&](const ProgressEvent& event) { events.push_back(event); });
  const Solution solution = SolveMesh(oracle::Cube(), {.max_sweeps = 50}, context);
  ASSERT_EQ(events.size(), solution.report.sweeps);
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].stage, "solve");
    EXPECT_EQ(events[i].sweep, i + 1);
    EXPECT_GT(events[i].fraction, 0);
    EXPECT_LE(events[i].fraction, 1);
  }
  EXPECT_EQ(events.back().update, solution.report.last_update);
}

TEST(Solve, EndsInTheSweepInWhichTheJobIsCancelled) {
  const PolygonMesh mesh = oracle::Cube();
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  const LimitStencil stencil = DooSabinModifiedStencil();
  for (const SolveMethod method : kMethods) {
    Context context;
    std::uint32_t last = 0;
    context.set_progress([&](const ProgressEvent& event) {
      last = event.sweep;
      if (event.sweep == 3) context.Cancel();
    });
    std::vector<Vec3> points(mesh.vertex_count());
    const auto report =
        Solve(context, {.mesh = built, .stencil = stencil, .points = mesh.positions},
              {.method = method, .tolerance = 0}, absl::MakeSpan(points));
    oracle::ExpectError(report.status(), {Reason::kCancelled});
    EXPECT_EQ(last, 3U);
  }
}

TEST(Solve, HasTheSameBitsForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(
      const PolygonMesh mesh,
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 20000, .seed = 8}));
  for (const SolveMethod method : kMethods) {
    const auto solve = [&](int threads) {
      return oracle::WithThreads(
          threads, [&] { return SolveMesh(mesh, {.method = method, .tolerance = 1e-6}); });
    };
    const Solution one = solve(1);
    for (const int threads : {2, 5}) {
      const Solution many = solve(threads);
      EXPECT_EQ(one.points, many.points);
      EXPECT_EQ(one.report.sweeps, many.report.sweeps);
      EXPECT_EQ(one.report.last_update, many.report.last_update);
      EXPECT_EQ(one.report.residual, many.report.residual);
    }
  }
}

// Edge weights make simultaneous methods keep two arrays: the same answer is due.
TEST(Solve, SolvesStencilsWithEdgeWeights) {
  const PolygonMesh mesh = oracle::Jittered(oracle::TorusOfTriangles(6, 5), 6, 0.2);
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  LimitStencil stencil;
  stencil.rows = {{.vertex = 0.7, .edges = 0.2, .faces = 0.1}};
  // By Gershgorin's circles.
  stencil.spectrum_low = 0.4;
  stencil.spectrum_high = 1;
  std::vector<std::vector<Vec3>> solutions;
  for (const SolveMethod method : kMethods) {
    std::vector<Vec3> points(mesh.vertex_count());
    const auto report =
        Solve(Context(), {.mesh = built, .stencil = stencil, .points = mesh.positions},
              {.method = method, .tolerance = 1e-13}, absl::MakeSpan(points));
    ASSERT_TRUE(report.ok()) << report.status();
    EXPECT_TRUE(report->converged);
    EXPECT_LE(report->residual, 1e-13);
    solutions.push_back(points);
  }
  for (const auto& points : solutions) {
    EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(points), oracle::FromVec3(solutions[0])), 1e-12);
  }
}

}  // namespace
}  // namespace limn
