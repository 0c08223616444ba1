// SPDX-License-Identifier: MIT
// Boundary curves through given points, against dense solutions.
#include "engine/solve/curve_solve.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "tests/oracle/dense.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

struct Problem {
  std::vector<Vec3> points;
  std::vector<std::uint8_t> fixed;
};

// A closed curve of n vertices.
BoundaryCurve Loop(std::size_t n) {
  BoundaryCurve curve;
  for (std::size_t i = 0; i < n; ++i) {
    curve.half_edge.push_back(static_cast<Index>(i));
    curve.next.push_back(static_cast<Index>((i + 1) % n));
    curve.previous.push_back(static_cast<Index>((i + n - 1) % n));
  }
  return curve;
}

Problem RandomProblem(std::size_t n, std::uint64_t seed, double fixed_part) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  Problem problem;
  for (std::size_t i = 0; i < n; ++i) {
    problem.points.push_back({coordinate(random), coordinate(random), coordinate(random)});
    problem.fixed.push_back(0.5 * (coordinate(random) + 1) < fixed_part ? 1 : 0);
  }
  return problem;
}

std::vector<Vec3> SolveOrDie(const Problem& problem, const CurveStencil& stencil = {}) {
  const BoundaryCurve curve = Loop(problem.points.size());
  std::vector<Vec3> control(problem.points.size());
  EXPECT_TRUE(
      SolveCurves(
          Context(),
          {.curve = curve, .points = problem.points, .fixed = problem.fixed, .stencil = stencil},
          absl::MakeSpan(control))
          .ok());
  return control;
}

TEST(CurveSolve, IsTheDenseSolutionOfLoopsAndOfPiecesBetweenFixedVertices) {
  // Quadratic and cubic B-splines.
  for (const CurveStencil& stencil : {kQuadraticCurve, CurveStencil{2.0 / 3, 1.0 / 6}}) {
    for (const std::size_t n : {3U, 4U, 5U, 17U, 60U}) {
      for (const double part : {0.0, 0.1, 0.5, 1.0}) {
        SCOPED_TRACE(testing::Message() << n << " vertices, fixed " << part << ", seed " << n);
        const Problem problem = RandomProblem(n, n, part);
        oracle::Matrix matrix(n, std::vector<oracle::Real>(n, 0));
        for (std::size_t i = 0; i < n; ++i) {
          matrix[i][i] = problem.fixed[i] != 0 ? 1 : stencil.vertex;
          if (problem.fixed[i] != 0) continue;
          matrix[i][(i + 1) % n] += stencil.neighbour;
          matrix[i][(i + n - 1) % n] += stencil.neighbour;
        }
        const oracle::Points expected = SolveDense(matrix, oracle::FromVec3(problem.points));
        EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(SolveOrDie(problem, stencil)), expected),
                  2e-15);
      }
    }
  }
}

TEST(CurveSolve, ReversedCurvesGiveTheSameBits) {
  for (const double part : {0.0, 0.2}) {
    Problem problem = RandomProblem(50, 7, part);
    std::vector<Vec3> forward = SolveOrDie(problem);
    std::reverse(problem.points.begin(), problem.points.end());
    std::reverse(problem.fixed.begin(), problem.fixed.end());
    std::reverse(forward.begin(), forward.end());
    EXPECT_EQ(SolveOrDie(problem), forward);
  }
}

TEST(CurveSolve, PiecesBetweenFixedVerticesDoNotSeeTheRest) {
  Problem problem = RandomProblem(40, 3, 0);
  problem.fixed[5] = problem.fixed[20] = 1;
  const std::vector<Vec3> before = SolveOrDie(problem);
  for (std::size_t i = 21; i < 40; ++i) problem.points[i] += Vec3{1, 2, 3};
  for (std::size_t i = 0; i < 5; ++i) problem.points[i] += Vec3{1, 2, 3};
  const std::vector<Vec3> after = SolveOrDie(problem);
  for (std::size_t i = 5; i <= 20; ++i) EXPECT_EQ(before[i], after[i]) << i;
  EXPECT_NE(before[21], after[21]);
}

TEST(CurveSolve, FixedVerticesKeepTheirPointsToTheBit) {
  const Problem problem = RandomProblem(30, 9, 0.4);
  const std::vector<Vec3> control = SolveOrDie(problem);
  for (std::size_t i = 0; i < control.size(); ++i) {
    if (problem.fixed[i] != 0) {
      EXPECT_EQ(control[i], problem.points[i]);
    }
  }
}

TEST(CurveSolve, EndsWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  const BoundaryCurve curve = Loop(3);
  const Problem problem = RandomProblem(3, 1, 0);
  std::vector<Vec3> control(3);
  oracle::ExpectError(
      SolveCurves(cancelled, {.curve = curve, .points = problem.points, .fixed = problem.fixed},
                  absl::MakeSpan(control)),
      {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
