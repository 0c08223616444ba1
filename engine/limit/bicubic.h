// SPDX-License-Identifier: MIT
// One uniform bicubic B-spline patch: the Catmull-Clark surface in a quad whose corners have four
// faces each. Source: Catmull and Clark 1978.
//
//   (j)  3   o---o---o---o     The patch is the square (u, v) in [0, 1]^2 between the four points
//        2   o---x---x---o     in the middle; u grows with the column i, v with the row j. A unit
//        1   o---x---x---o     of u is the distance between two columns.
//        0   o---o---o---o
//       v ^  0   1   2   3  (i), u ->
#pragma once

#include <array>
#include <cstddef>

#include "engine/base/vec3.h"
#include "engine/limit/spline_jet.h"

namespace limn {

// net[j][i]: row j, column i.
using BicubicNet = std::array<std::array<Vec3, 4>, 4>;

// Weights of four control points, for the curve and its derivative; they add up to 1 and 0.
struct CubicWeights {
  std::array<double, 4> value;
  std::array<double, 4> first;
};
constexpr CubicWeights CubicBSpline(double t) {
  const double s = 1 - t;
  const double tt = t * t;
  const double ss = s * s;
  return {{s * ss / 6, (4 - 3 * tt * (1 + s)) / 6, (4 - 3 * ss * (1 + t)) / 6, t * tt / 6},
          {-0.5 * ss, 0.5 * t * (3 * t - 4), 0.5 * s * (4 - 3 * s), 0.5 * tt}};
}

// u, v: in [0, 1]. Exact but for rounding. Thread-safe.
constexpr SplineJet EvaluateBicubic(const BicubicNet& net, double u, double v) {
  const CubicWeights a = CubicBSpline(u);
  const CubicWeights b = CubicBSpline(v);
  SplineJet jet = {};
  for (std::size_t j = 0; j < 4; ++j) {
    const std::array<Vec3, 4>& p = net[j];
    const auto along = [&](const std::array<double, 4>& w) {
      return (w[0] * p[0] + w[1] * p[1]) + (w[2] * p[2] + w[3] * p[3]);
    };
    const Vec3 point = along(a.value);
    jet.point += b.value[j] * point;
    jet.du += b.value[j] * along(a.first);
    jet.dv += b.first[j] * point;
  }
  return jet;
}

}  // namespace limn
