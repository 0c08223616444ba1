// SPDX-License-Identifier: MIT
// One quartic box spline patch: the Loop surface in a triangle whose corners have six faces each.
// Sources: Loop 1987; Stam, "Evaluation of Loop subdivision surfaces", 1998 (the polynomials, here
// with their symmetry).
#pragma once

#include <array>
#include <cstddef>

#include "engine/base/vec3.h"
#include "engine/limit/spline_jet.h"

namespace limn {

// The corners of a triangle and the six points around each, counter-clockwise from the next
// corner: around corner i
//   0: corner i + 1,  1: corner i - 1,  2: across the side to corner i - 1,  3 and 4: its own,
//   5: across the side to corner i + 1, which is number 2 of corner i + 1.
struct BoxSplineNet {
  std::array<Vec3, 3> corner;
  std::array<std::array<Vec3, 6>, 3> around;
};

// A polynomial in the barycentric coordinates a, b, c of a triangle, and its partial derivatives.
struct BarycentricJet {
  double value;
  double da;
  double db;
  double dc;
};

// Weights of a quartic box spline's control points. All of a patch add up to 1.
// Of corner a.
constexpr BarycentricJet BoxSplineCorner(double a, double b, double c) {
  const double t = b + c;
  const double q = b * c;
  const double dt =
      24 * a * a * a + 48 * a * a * t + 24 * a * t * t + 4 * t * t * t + 12 * a * q + 4 * t * q;
  const double dq = 12 * a * a + 12 * a * t + 2 * t * t + 4 * q;
  const double value = a * a * (6 * a * a + 24 * a * t + 24 * t * t) + 8 * a * t * t * t +
                       t * t * t * t + q * (12 * a * a + 12 * a * t + 2 * t * t + 2 * q);
  const double da =
      24 * a * a * a + 72 * a * a * t + 48 * a * t * t + 8 * t * t * t + 24 * a * q + 12 * t * q;
  return {value / 12, da / 12, (dt + c * dq) / 12, (dt + b * dq) / 12};
}
// Of the point across the side from a to b.
constexpr BarycentricJet BoxSplineAcross(double a, double b, double c) {
  const double s = a + b;
  const double p = a * b;
  const double sss = s * s * s;
  const double ds = 4 * sss + 4 * p * s + 6 * c * s * s;
  const double dp = 2 * s * s + 4 * p;
  return {(s * sss + 2 * p * (s * s + p) + 2 * c * sss) / 12, (ds + b * dp) / 12,
          (ds + a * dp) / 12, sss / 6};
}
// Of a's own point next to the one across the side to b.
constexpr BarycentricJet BoxSplineOwn(double a, double b) {
  const double aaa = a * a * a;
  return {(a + 2 * b) * aaa / 12, (4 * aaa + 6 * a * a * b) / 12, aaa / 6, 0};
}

// u: coordinate of corner 1; v: of corner 2; both and their sum in [0, 1]. The derivatives are by u
// and v. Exact but for rounding. Thread-safe.
constexpr SplineJet EvaluateBoxSpline(const BoxSplineNet& net, double u, double v) {
  const std::array<double, 3> w = {(1 - u) - v, u, v};
  SplineJet jet = {};
  // By the three coordinates.
  std::array<Vec3, 3> d = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    const std::size_t prev = (i + 2) % 3;
    const std::array<Vec3, 6>& p = net.around[i];
    const auto add = [&](const BarycentricJet& weight, std::size_t b, std::size_t c,
                         const Vec3& point) {
      jet.point += weight.value * point;
      d[i] += weight.da * point;
      d[b] += weight.db * point;
      d[c] += weight.dc * point;
    };
    add(BoxSplineCorner(w[i], w[next], w[prev]), next, prev, net.corner[i]);
    add(BoxSplineAcross(w[i], w[next], w[prev]), next, prev, p[5]);
    add(BoxSplineOwn(w[i], w[next]), next, prev, p[4]);
    add(BoxSplineOwn(w[i], w[prev]), prev, next, p[3]);
  }
  jet.du = d[1] - d[0];
  jet.dv = d[2] - d[0];
  return jet;
}

}  // namespace limn
