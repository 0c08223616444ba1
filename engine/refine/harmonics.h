// SPDX-License-Identifier: MIT
// The discrete Fourier components of a face that Doo-Sabin refinement distinguishes.
// Source: Doo and Sabin 1978: the refinement of an m-gon is circulant with eigenvalues 1 (mean),
// 1/2 (first harmonic) and 1/4 (the rest).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "engine/base/vec3.h"

namespace limn {

// Mean and first harmonic of points p(0) .. p(m - 1): t1 = sum cos(2 pi i / m) p(i),
// t2 = sum sin(2 pi i / m) p(i). t1 x t2 is normal to the limit surface at the mean.
struct Harmonics {
  Vec3 mean;
  Vec3 t1;
  Vec3 t2;
};

// cos and sin of 2 pi i / m.
struct UnitAngle {
  double cos;
  double sin;
};

// Those of all small m, since computing them costs more than all else that is done with them.
class UnitAngles {
 public:
  UnitAngles() {
    for (std::size_t m = 1; m < kSmall; ++m) {
      for (std::size_t i = 0; i < m; ++i) table_[Place(i, m)] = Compute(i, m);
    }
  }
  // 0 <= i < m.
  UnitAngle operator()(std::size_t i, std::size_t m) const {
    return m < kSmall ? table_[Place(i, m)] : Compute(i, m);
  }

 private:
  static constexpr std::size_t kSmall = 32;
  static std::size_t Place(std::size_t i, std::size_t m) { return m * (m - 1) / 2 + i; }
  static UnitAngle Compute(std::size_t i, std::size_t m) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(m);
    return {std::cos(angle), std::sin(angle)};
  }
  std::array<UnitAngle, kSmall*(kSmall - 1) / 2> table_;
};
inline const UnitAngles kUnitAngles;

inline UnitAngle AngleOf(std::size_t i, std::size_t m) { return kUnitAngles(i, m); }

// Differences to p(0) are summed, so that points far from the origin lose nothing.
template <class Point>
Harmonics FirstHarmonics(std::size_t m, const Point& p) {
  Harmonics result = {p(0), {0, 0, 0}, {0, 0, 0}};
  const Vec3 origin = p(0);
  Vec3 sum = {0, 0, 0};
  for (std::size_t i = 1; i < m; ++i) {
    const Vec3 d = p(i) - origin;
    const UnitAngle angle = AngleOf(i, m);
    sum += d;
    result.t1 += angle.cos * d;
    result.t2 += angle.sin * d;
  }
  result.mean = origin + (1.0 / static_cast<double>(m)) * sum;
  return result;
}

}  // namespace limn
