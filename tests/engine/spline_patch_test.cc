// SPDX-License-Identifier: MIT
// Bicubic and quartic box spline patches: weights, derivatives and symmetry.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "engine/limit/bicubic.h"
#include "engine/limit/box_spline.h"

namespace limn {
namespace {

constexpr double kPlaces[] = {0, 0.1, 0.25, 1.0 / 3, 0.5, 0.7, 0.9, 1};

TEST(Bicubic, WeightsAreThoseOfTheCubicBSpline) {
  for (const double t : kPlaces) {
    const CubicWeights w = CubicBSpline(t);
    const double s = 1 - t;
    EXPECT_NEAR(w.value[0], s * s * s / 6, 1e-16);
    EXPECT_NEAR(w.value[1], (3 * t * t * t - 6 * t * t + 4) / 6, 2e-16);
    EXPECT_NEAR(w.value[2], (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, 2e-16);
    EXPECT_NEAR(w.value[3], t * t * t / 6, 1e-16);
    EXPECT_NEAR(std::accumulate(w.value.begin(), w.value.end(), 0.0), 1, 3e-16);
    EXPECT_NEAR(std::accumulate(w.first.begin(), w.first.end(), 0.0), 0, 3e-16);
    const double h = 1e-6;
    const CubicWeights after = CubicBSpline(t + h);
    const CubicWeights before = CubicBSpline(t - h);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_NEAR(w.first[i], (after.value[i] - before.value[i]) / (2 * h), 1e-9);
    }
  }
}

TEST(Bicubic, ReproducesPlanes) {
  BicubicNet net;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      net[j][i] = {static_cast<double>(i) - 1, static_cast<double>(j) - 1, 7};
    }
  }
  for (const double u : kPlaces) {
    for (const double v : kPlaces) {
      const SplineJet jet = EvaluateBicubic(net, u, v);
      EXPECT_LE(MaxAbs(jet.point - Vec3{u, v, 7}), 5e-15);
      EXPECT_LE(MaxAbs(jet.du - Vec3{1, 0, 0}), 5e-15);
      EXPECT_LE(MaxAbs(jet.dv - Vec3{0, 1, 0}), 5e-15);
    }
  }
}

// The net whose points are `f` of their coordinates.
template <class F>
BoxSplineNet NetOf(const F& f) {
  // Around a vertex, counter-clockwise: (1, 0), (0, 1), (-1, 1), ...
  constexpr double kStep[6][2] = {{1, 0}, {0, 1}, {-1, 1}, {-1, 0}, {0, -1}, {1, -1}};
  constexpr double kCorner[3][2] = {{0, 0}, {1, 0}, {0, 1}};
  BoxSplineNet net;
  for (std::size_t i = 0; i < 3; ++i) {
    net.corner[i] = f(kCorner[i][0], kCorner[i][1]);
    for (std::size_t j = 0; j < 6; ++j) {
      const std::size_t step = (j + 2 * i) % 6;
      net.around[i][j] = f(kCorner[i][0] + kStep[step][0], kCorner[i][1] + kStep[step][1]);
    }
  }
  return net;
}

TEST(BoxSpline, ReproducesPlanes) {
  const BoxSplineNet net = NetOf([](double x, double y) { return Vec3{x, y, 7}; });
  for (const double u : kPlaces) {
    for (const double v : kPlaces) {
      if (u + v > 1) continue;
      const SplineJet jet = EvaluateBoxSpline(net, u, v);
      EXPECT_LE(MaxAbs(jet.point - Vec3{u, v, 7}), 5e-15);
      EXPECT_LE(MaxAbs(jet.du - Vec3{1, 0, 0}), 2e-14);
      EXPECT_LE(MaxAbs(jet.dv - Vec3{0, 1, 0}), 2e-14);
    }
  }
}

// Weights of single points: derivatives, and at corners the limit mask 1/2, 1/12.
TEST(BoxSpline, HasTheLimitMaskAndItsOwnDerivatives) {
  for (int i = -1; i <= 2; ++i) {
    for (int j = -1; j <= 2; ++j) {
      const auto only = [&](double x, double y) {
        return Vec3{x == i && y == j ? 1.0 : 0.0, 0, 0};
      };
      const BoxSplineNet net = NetOf(only);
      const bool neighbour = (i == 1 && j == 0) || (i == 0 && j == 1) || (i == -1 && j == 1) ||
                             (i == -1 && j == 0) || (i == 0 && j == -1) || (i == 1 && j == -1);
      const double expected = i == 0 && j == 0 ? 0.5 : (neighbour ? 1 / 12.0 : 0);
      EXPECT_NEAR(EvaluateBoxSpline(net, 0, 0).point.x, expected, 1e-16);
      const double h = 1e-6;
      for (const auto& [u, v] : {std::pair(0.2, 0.3), std::pair(0.6, 0.1), {0.1, 0.8}}) {
        const SplineJet jet = EvaluateBoxSpline(net, u, v);
        EXPECT_NEAR(
            jet.du.x,
            (EvaluateBoxSpline(net, u + h, v).point.x - EvaluateBoxSpline(net, u - h, v).point.x) /
                (2 * h),
            1e-9);
        EXPECT_NEAR(
            jet.dv.x,
            (EvaluateBoxSpline(net, u, v + h).point.x - EvaluateBoxSpline(net, u, v - h).point.x) /
                (2 * h),
            1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace limn
