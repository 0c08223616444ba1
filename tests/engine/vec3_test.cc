// SPDX-License-Identifier: MIT
#include "engine/base/vec3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace limn {
namespace {

constexpr Vec3 kZero = {0, 0, 0};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Vec3, NormalizesEveryLength) {
  for (const double size : {5e-324, 1e-310, 1e-200, 1e-100, 1.0, 1e100, 1e200, 1e308}) {
    EXPECT_EQ(NormalizedOrZero({0, -size, 0}), (Vec3{0, -1, 0})) << size;
  }
  for (const double size : {1e-300, 1e-200, 1e-100, 1.0, 1e100, 1e200, 1e307}) {
    const Vec3 unit = NormalizedOrZero({size, 2 * size, -2 * size});
    EXPECT_LE(MaxAbs(unit - Vec3{1.0 / 3, 2.0 / 3, -2.0 / 3}), 1e-15) << size;
  }
}

TEST(Vec3, WhatHasNoDirectionNormalizesToZero) {
  EXPECT_EQ(NormalizedOrZero(kZero), kZero);
  EXPECT_EQ(NormalizedOrZero({kInfinity, 0, 0}), kZero);
  EXPECT_EQ(NormalizedOrZero({std::nan(""), std::nan(""), std::nan("")}), kZero);
}

TEST(Vec3, UnitCrossIsNormalToBothAtEverySize) {
  const Vec3 a = {1, 2, 2};
  const Vec3 b = {2, 1, -2};  // at right angles to a
  const Vec3 expected = {-2.0 / 3, 2.0 / 3, -1.0 / 3};
  for (const double size_a : {1e-310, 1e-200, 1e-50, 1.0, 1e50, 1e100}) {
    for (const double size_b : {1e-310, 1e-200, 1e-50, 1.0, 1e50, 1e100}) {
      const double size = std::min(size_a, size_b);
      EXPECT_LE(MaxAbs(UnitCross(size_a * a, size_b * b, size) - expected), 1e-12)
          << size_a << ", " << size_b;
    }
  }
}

TEST(Vec3, UnitCrossIsZeroBelowRounding) {
  for (const double scale : {1e-300, 1e-200, 1.0, 1e99}) {
    const Vec3 a = scale * Vec3{0.3, 0.7, -0.2};
    EXPECT_EQ(UnitCross(a, 3.1 * a, 0), kZero);
    EXPECT_EQ(UnitCross(a, -1e-17 * a, scale), kZero);
    EXPECT_EQ(UnitCross(a, kZero, scale), kZero);
    EXPECT_EQ(UnitCross(kZero, a, scale), kZero);
    // Off by rounding of coordinates a million times as large.
    EXPECT_EQ(UnitCross(a, a + scale * Vec3{1e-10, 0, 0}, 1e6 * scale), kZero);
    EXPECT_NE(UnitCross(a, a + scale * Vec3{1e-10, 0, 0}, scale), kZero);
  }
}

TEST(Vec3, MaxAbsIsTheLargestCoordinate) {
  EXPECT_EQ(MaxAbs({-3, 2, 1}), 3);
  EXPECT_EQ(MaxAbs({1, -3, 2}), 3);
  EXPECT_EQ(MaxAbs({1, 2, -3}), 3);
  EXPECT_EQ(MaxAbs(kZero), 0);
}

TEST(Vec3, FiniteMeansAllCoordinates) {
  EXPECT_TRUE(IsFinite({1e308, -1e308, 5e-324}));
  for (const double bad : {kInfinity, -kInfinity, std::nan("")}) {
    EXPECT_FALSE(IsFinite({bad, 0, 0}));
    EXPECT_FALSE(IsFinite({0, bad, 0}));
    EXPECT_FALSE(IsFinite({0, 0, bad}));
  }
}

}  // namespace
}  // namespace limn
