// SPDX-License-Identifier: MIT
#include "engine/limit/biquadratic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace limn {
namespace {

BiquadraticNet RandomNet(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  BiquadraticNet net;
  for (auto& row : net) {
    for (Vec3& p : row) p = {coordinate(random), coordinate(random), coordinate(random)};
  }
  return net;
}

// The Cox and de Boor recursion over the knots -2, -1, 0, 1, 2, 3: B-spline i of this degree.
double CoxDeBoor(int i, int degree, double t) {
  const double knot = i - 2;
  if (degree == 0) return knot <= t && t < knot + 1 ? 1 : 0;
  return (t - knot) / degree * CoxDeBoor(i, degree - 1, t) +
         (knot + degree + 1 - t) / degree * CoxDeBoor(i + 1, degree - 1, t);
}

TEST(Biquadratic, PointIsTheSumOfTensorProductBSplines) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const BiquadraticNet net = RandomNet(seed);
    for (double u = 0; u < 1; u += 0.125) {
      for (double v = 0; v < 1; v += 0.125) {
        Vec3 expected = {0, 0, 0};
        for (int j = 0; j < 3; ++j) {
          for (int i = 0; i < 3; ++i) {
            expected += CoxDeBoor(i, 2, u) * CoxDeBoor(j, 2, v) * net[j][i];
          }
        }
        EXPECT_LE(MaxAbs(EvaluateBiquadratic(net, u, v).point - expected), 1e-15) << seed;
      }
    }
  }
}

// Differences of a quadratic are its derivatives exactly, whatever the step.
TEST(Biquadratic, DerivativesAreThoseOfThePolynomial) {
  constexpr double kStep = 0.25;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const BiquadraticNet net = RandomNet(seed);
    const auto at = [&](double u, double v) { return EvaluateBiquadratic(net, u, v).point; };
    for (double u = 0; u <= 1; u += 0.25) {
      for (double v = 0; v <= 1; v += 0.25) {
        const BiquadraticJet jet = EvaluateBiquadratic(net, u, v);
        const double h = kStep;
        EXPECT_LE(MaxAbs(jet.du - 0.5 / h * (at(u + h, v) - at(u - h, v))), 1e-14);
        EXPECT_LE(MaxAbs(jet.dv - 0.5 / h * (at(u, v + h) - at(u, v - h))), 1e-14);
        EXPECT_LE(MaxAbs(jet.duu - 1 / (h * h) * (at(u + h, v) + at(u - h, v) - 2 * at(u, v))),
                  1e-13);
        EXPECT_LE(MaxAbs(jet.dvv - 1 / (h * h) * (at(u, v + h) + at(u, v - h) - 2 * at(u, v))),
                  1e-13);
        EXPECT_LE(MaxAbs(jet.duv - 0.25 / (h * h) *
                                       (at(u + h, v + h) - at(u + h, v - h) - at(u - h, v + h) +
                                        at(u - h, v - h))),
                  1e-13);
      }
    }
  }
}

TEST(Biquadratic, CornersAreTheCentroidsOfTheFourFaces) {
  const BiquadraticNet net = RandomNet(3);
  for (const std::size_t j : {0, 1}) {
    for (const std::size_t i : {0, 1}) {
      const Vec3 centroid = 0.25 * (net[j][i] + net[j][i + 1] + net[j + 1][i] + net[j + 1][i + 1]);
      EXPECT_LE(
          MaxAbs(EvaluateBiquadratic(net, static_cast<double>(i), static_cast<double>(j)).point -
                 centroid),
          1e-15);
    }
  }
}

TEST(Biquadratic, ColumnsRunAlongUAndRowsAlongV) {
  BiquadraticNet net;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      net[j][i] = {static_cast<double>(i) - 0.5, static_cast<double>(j) - 0.5, 0};
    }
  }
  const BiquadraticJet jet = EvaluateBiquadratic(net, 0.25, 0.75);
  EXPECT_EQ(jet.point, (Vec3{0.25, 0.75, 0}));
  EXPECT_EQ(jet.du, (Vec3{1, 0, 0}));
  EXPECT_EQ(jet.dv, (Vec3{0, 1, 0}));
  EXPECT_EQ(jet.duu, (Vec3{0, 0, 0}));
  EXPECT_EQ(jet.duv, (Vec3{0, 0, 0}));
  EXPECT_EQ(jet.dvv, (Vec3{0, 0, 0}));
}

}  // namespace
}  // namespace limn
