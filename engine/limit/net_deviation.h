// SPDX-License-Identifier: MIT
// How far a biquadratic patch is from the bilinear patch of its corners, apart along a direction n
// and across it. Used by engine/limit/chord_bound.h.
//
// S - Q = -u (1 - u) / 2 S_uu(v) - v (1 - v) / 2 ((1 - u) S_vv(0) + u S_vv(1)), as S is quadratic
// along each parameter and S_uu does not depend on u. S_uu(v) lies in the hull of its Bezier
// points, the second differences of the net's rows and the means of neighbouring ones. So |S - Q|
// is at most an eighth of the largest of these plus that of the columns'; a piece of the patch of
// 2^-j of the size has 4^-j of it. Q and its split by either diagonal differ by at most a quarter
// of the twist, which is the mean of S_uv, which lies in the hull of the four mixed differences.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/vec3.h"
#include "engine/limit/biquadratic.h"
#include "engine/limit/projected_cone.h"

namespace limn {

// Bounds of a difference's part along n and of its part across n.
struct Deviation {
  double height = 0;
  double slide = 0;

  void Widen(const Deviation& other) {
    height = std::max(height, other.height);
    slide = std::max(slide, other.slide);
  }
  double length() const { return std::hypot(height, slide); }
  friend Deviation operator+(const Deviation& a, const Deviation& b) {
    return {a.height + b.height, a.slide + b.slide};
  }
  friend Deviation operator*(double s, const Deviation& a) { return {s * a.height, s * a.slide}; }
};

// normal: unit or zero.
inline Deviation PartsOf(const Vec3& a, const Vec3& normal) {
  const double height = Dot(a, normal);
  return {std::fabs(height), Norm(a - height * normal)};
}

struct NetDeviation {
  // Of the patch from the bilinear one.
  Deviation bilinear;
  // Of the bilinear one from its triangles.
  Deviation split;

  Deviation sum() const { return bilinear + split; }
};

inline NetDeviation DeviationOf(const BiquadraticNet& net, const Vec3& normal) {
  std::array<Vec3, 3> rows{};
  std::array<Vec3, 3> columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    rows[i] = net[i][0] - 2 * net[i][1] + net[i][2];
    columns[i] = net[0][i] - 2 * net[1][i] + net[2][i];
  }
  const auto largest = [&](const std::array<Vec3, 3>& second) {
    Deviation most = PartsOf(second[1], normal);
    most.Widen(PartsOf(0.5 * (second[0] + second[1]), normal));
    most.Widen(PartsOf(0.5 * (second[1] + second[2]), normal));
    return most;
  };
  NetDeviation result;
  result.bilinear = 0.125 * (largest(rows) + largest(columns));
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 twist = (net[j][i] - net[j][i + 1]) - (net[j + 1][i] - net[j + 1][i + 1]);
      result.split.Widen(0.25 * PartsOf(twist, normal));
    }
  }
  return result;
}

// The Bezier points of S_u and S_v, times a factor.
struct NetDerivatives {
  std::array<Vec3, 6> u;
  std::array<Vec3, 6> v;
};

inline NetDerivatives DerivativesOf(const BiquadraticNet& net, double factor) {
  NetDerivatives result{};
  for (std::size_t k = 0; k < 2; ++k) {
    std::array<Vec3, 3> along_u{};
    std::array<Vec3, 3> along_v{};
    for (std::size_t i = 0; i < 3; ++i) {
      along_u[i] = factor * (net[i][k + 1] - net[i][k]);
      along_v[i] = factor * (net[k + 1][i] - net[k][i]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      result.u[3 * k + i] = i == 1 ? along_u[1] : 0.5 * (along_u[i] + along_u[1]);
      result.v[3 * k + i] = i == 1 ? along_v[1] : 0.5 * (along_v[i] + along_v[1]);
    }
  }
  return result;
}

}  // namespace limn
