// SPDX-License-Identifier: MIT
// One uniform biquadratic B-spline patch: where the four faces around a Doo-Sabin control point are
// quads, the limit surface around that point is this. Source: Doo and Sabin 1978.
//
//   (j)  2   o---o---o     The patch is the square (u, v) in [0, 1]^2 around the middle point;
//        1   o---x---o     u grows with the column i, v with the row j. A unit of u is the distance
//        0   o---o---o     between two columns.
//       v ^  0   1   2  (i), u ->
#pragma once

#include <array>
#include <cstddef>

#include "engine/base/vec3.h"

namespace limn {

// net[j][i]: row j, column i.
using BiquadraticNet = std::array<std::array<Vec3, 3>, 3>;

// The point and its derivatives by u and v.
struct BiquadraticJet {
  Vec3 point;
  Vec3 du;
  Vec3 dv;
  Vec3 duu;
  Vec3 duv;
  Vec3 dvv;
};

// Weights of three control points, for the curve and its derivatives; they add up to 1, 0, 0.
struct QuadraticWeights {
  std::array<double, 3> value;
  std::array<double, 3> first;
  std::array<double, 3> second;
};
constexpr QuadraticWeights QuadraticBSpline(double t) {
  const double s = 1 - t;
  return {{0.5 * s * s, 0.5 + s * t, 0.5 * t * t}, {-s, s - t, t}, {1, -2, 1}};
}

// u, v: in [0, 1]; outside, the polynomial goes on. Exact but for rounding. Thread-safe.
constexpr BiquadraticJet EvaluateBiquadratic(const BiquadraticNet& net, double u, double v) {
  const QuadraticWeights a = QuadraticBSpline(u);
  const QuadraticWeights b = QuadraticBSpline(v);
  const auto along = [](const std::array<double, 3>& weight, const Vec3& p, const Vec3& q,
                        const Vec3& r) { return weight[0] * p + weight[1] * q + weight[2] * r; };
  // Rows first: their points and derivatives are the control points of curves along v.
  std::array<Vec3, 3> point{};
  std::array<Vec3, 3> first{};
  std::array<Vec3, 3> second{};
  for (std::size_t j = 0; j < 3; ++j) {
    point[j] = along(a.value, net[j][0], net[j][1], net[j][2]);
    first[j] = along(a.first, net[j][0], net[j][1], net[j][2]);
    second[j] = along(a.second, net[j][0], net[j][1], net[j][2]);
  }
  return {.point = along(b.value, point[0], point[1], point[2]),
          .du = along(b.value, first[0], first[1], first[2]),
          .dv = along(b.first, point[0], point[1], point[2]),
          .duu = along(b.value, second[0], second[1], second[2]),
          .duv = along(b.first, first[0], first[1], first[2]),
          .dvv = along(b.second, point[0], point[1], point[2])};
}

}  // namespace limn
