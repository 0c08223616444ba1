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

constexpr double MaxAbs(const Vec3& a) {
  const double ax = a.x < 0 ? -a.x : a.x;
  const double ay = a.y < 0 ? -a.y : a.y;
  const double az = a.z < 0 ? -a.z : a.z;
  return std::max(ax, std::max(ay, az));
}

inline bool IsFinite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

// a / |a|, or (0, 0, 0) where |a| is zero or not finite. Scaled first, so that lengths near the
// ends of the exponent range do not under- or overflow.
inline Vec3 NormalizedOrZero(const Vec3& a) {
  const double scale = MaxAbs(a);
  if (!(scale > 0) || !std::isfinite(scale)) return {0, 0, 0};
  const Vec3 s = {a.x / scale, a.y / scale, a.z / scale};
  const double n = Norm(s);
  return {s.x / n, s.y / n, s.z / n};
}

}  // namespace limn
