// SPDX-License-Identifier: MIT
#include "engine/constraints/blend_map.h"

namespace limn {
namespace {

Matrix3 Times(const Matrix3& a, const Matrix3& b) {
  return {{a * b.column[0], a * b.column[1], a * b.column[2]}};
}

Matrix3 Transposed(const Matrix3& m) {
  const Vec3(&c)[3] = m.column;
  return {{{c[0].x, c[1].x, c[2].x}, {c[0].y, c[1].y, c[2].y}, {c[0].z, c[1].z, c[2].z}}};
}

// The smallest rotation of the unit vector a to the unit vector b. spare: the axis of half a turn,
// perpendicular to a.
Matrix3 Rotation(const Vec3& a, const Vec3& b, const Vec3& spare) {
  const double cosine = Dot(a, b);
  const Vec3 axis = Cross(a, b);
  constexpr double kHalfTurn = -0.999999;
  Matrix3 m;
  for (int i = 0; i < 3; ++i) {
    const Vec3 e = Matrix3().column[i];
    m.column[i] = cosine > kHalfTurn
                      ? e + Cross(axis, e) + 1 / (1 + cosine) * Cross(axis, Cross(axis, e))
                      : 2 * Dot(spare, e) * spare - e;
  }
  if (cosine > kHalfTurn) return m;
  // The rest of the way is small.
  return Times(Rotation(m * a, b, spare), m);
}

// The inverse of {a, b, n}, n being the unit normal of the plane of a and b.
Matrix3 InverseFrame(const Vec3& a, const Vec3& b, const Vec3& n) {
  const double area = Dot(Cross(a, b), n);
  return Transposed({{1 / area * Cross(b, n), 1 / area * Cross(n, a), n}});
}

Vec3 SameSide(const Vec3& direction, const Vec3& as) {
  return Dot(direction, as) < 0 ? -direction : direction;
}

// One derivative, to be `wanted`. n: the surface's normal.
Matrix3 Stretch(const Vec3& derivative, const Vec3& wanted, const Vec3& n,
                const std::optional<Vec3>& normal) {
  const Vec3 from = NormalizedOrZero(derivative);
  const Vec3 to = NormalizedOrZero(wanted);
  Matrix3 turn = Rotation(from, to, n);
  if (normal.has_value()) {
    const Vec3 up = SameSide(*normal, turn * n);
    turn = Times({{to, up, Cross(to, up)}}, Transposed({{from, n, Cross(from, n)}}));
  }
  const double more = Norm(wanted) / Norm(derivative) - 1;
  Matrix3 scale;
  for (Vec3& column : scale.column) column += more * Dot(from, column) * from;
  return Times(turn, scale);
}

}  // namespace

std::optional<AffineMap> MapTo(const BlendTarget& target, const PatchSample& now) {
  AffineMap map = {.from = now.point, .to = target.point.value_or(now.point), .linear = {}};
  const bool tangents = target.normal.has_value() || target.du.has_value() || target.dv.has_value();
  if (!tangents) return map;
  const Vec3& n = now.normal;
  if (n == Vec3{0, 0, 0}) return std::nullopt;
  if (target.du.has_value() && target.dv.has_value()) {
    const Vec3 up = NormalizedOrZero(Cross(*target.du, *target.dv));
    map.linear = Times({{*target.du, *target.dv, up}}, InverseFrame(now.du, now.dv, n));
  } else if (target.du.has_value()) {
    map.linear = Stretch(now.du, *target.du, n, target.normal);
  } else if (target.dv.has_value()) {
    map.linear = Stretch(now.dv, *target.dv, n, target.normal);
  } else {
    const Vec3 up = SameSide(*target.normal, n);
    map.linear = Rotation(n, up, n);
  }
  return map;
}

}  // namespace limn
