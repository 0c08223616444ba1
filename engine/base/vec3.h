// SPDX-License-Identifier: MIT
// Points and vectors of three doubles. Evaluation order is as written, so results are the same on
// every path that uses the same expression.
#pragma once

#include <algorithm>
#include <cmath>

namespace limn {

struct Vec3 {
  double x;
  double y;
  double z;

  constexpr Vec3& operator+=(const Vec3& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  constexpr Vec3& operator-=(const Vec3& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
  constexpr Vec3& operator*=(double s) {
    x *= s;
    y *= s;
    z *= s;
    return *this;
  }
  friend constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
  friend constexpr Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
  friend constexpr Vec3 operator*(double s, Vec3 a) { return a *= s; }
  friend constexpr Vec3 operator*(Vec3 a, double s) { return a *= s; }
  friend constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr bool operator==(const Vec3& a, const Vec3& b) = default;
};

constexpr double Dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

constexpr Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline double Norm(const Vec3& a) { return std::sqrt(Dot(a, a)); }

// Without branches: signs are random, and this runs once per vertex and sweep.
inline double MaxAbs(const Vec3& a) {
  return std::max(std::fabs(a.x), std::max(std::fabs(a.y), std::fabs(a.z)));
}

inline bool IsFinite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

// a / |a|, or (0, 0, 0) where |a| is zero or not finite. Vectors whose squares would under- or
// overflow are scaled first.
inline Vec3 NormalizedOrZero(const Vec3& a) {
  const double square = Dot(a, a);
  if (square > 1e-200 && square < 1e200) return (1 / std::sqrt(square)) * a;
  const double scale = MaxAbs(a);
  if (!(scale > 0) || !std::isfinite(scale)) return {0, 0, 0};
  const Vec3 s = {a.x / scale, a.y / scale, a.z / scale};
  return (1 / Norm(s)) * s;
}

// Rounding errors of a short sum of points, relative to their coordinates: what is smaller may be
// noise.
inline constexpr double kRoundingNoise = 0x1p-47;

// The direction of a x b as a unit vector, or zero where a and b span no plane: where the product
// is not above the rounding errors of a and b. size: magnitude of the coordinates that a and b were
// computed from.
inline Vec3 UnitCross(const Vec3& a, const Vec3& b, double size) {
  const Vec3 product = Cross(a, b);
  const double square = Dot(product, product);
  constexpr double kNoise = kRoundingNoise * kRoundingNoise;
  if (square > 1e-200 && square < 1e200) {
    const double aa = Dot(a, a);
    const double bb = Dot(b, b);
    if (square <= kNoise * (2 * size * size * (aa + bb) + aa * bb)) return {0, 0, 0};
    return (1 / std::sqrt(square)) * product;
  }
  const double scale_a = MaxAbs(a);
  const double scale_b = MaxAbs(b);
  if (!(scale_a > 0 && scale_b > 0)) return {0, 0, 0};
  // Divided, not multiplied by an inverse: that of a denormal is infinite.
  const Vec3 scaled = Cross({a.x / scale_a, a.y / scale_a, a.z / scale_a},
                            {b.x / scale_b, b.y / scale_b, b.z / scale_b});
  if (MaxAbs(scaled) <= kRoundingNoise * (size / scale_a + size / scale_b + 1)) return {0, 0, 0};
  return NormalizedOrZero(scaled);
}

}  // namespace limn
