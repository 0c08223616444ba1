// SPDX-License-Identifier: MIT
// How far a piece of surface turns away from a plane, and how much it shrinks when it is projected
// onto it, from finitely many of its derivatives. Used by engine/limit/chord_bound.h, which says
// what for.
//
// All that is kept about the derivatives a along one parameter holds for their convex hull as well,
// which is why it is kept in this form: with the unit vectors n (normal), x and y = n x x,
//   a . x >= least > 0,   low <= (a . y) / (a . x) <= high,   |a . n| <= slope (a . x).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/base/vec3.h"

namespace limn {

class DirectionCone {
 public:
  // Unit vectors, perpendicular to each other; zero vectors make a cone that is not valid.
  DirectionCone(const Vec3& normal, const Vec3& axis)
      : normal_(normal), axis_(axis), side_(Cross(normal, axis)) {}

  void Add(const Vec3& a) {
    const double along = Dot(a, axis_);
    least_ = std::min(least_, along);
    if (!(along > 0)) return;
    const double sideways = Dot(a, side_) / along;
    high_ = std::max(high_, sideways);
    low_ = std::min(low_, sideways);
    slope_ = std::max(slope_, std::fabs(Dot(a, normal_)) / along);
  }
  void Add(const DirectionCone& other) {
    least_ = std::min(least_, other.least_);
    high_ = std::max(high_, other.high_);
    low_ = std::min(low_, other.low_);
    slope_ = std::max(slope_, other.slope_);
  }

  // That of all vectors that differ from one in here by up to `in_plane` in the plane and
  // `off_plane` along the normal: both count most for the shortest.
  DirectionCone Widened(double in_plane, double off_plane) const {
    DirectionCone wide = *this;
    wide.least_ = least_ - in_plane;
    if (!wide.valid()) return wide;
    const double part = in_plane / least_;
    wide.high_ = (high_ + part) / (high_ + part > 0 ? 1 - part : 1 + part);
    wide.low_ = (low_ - part) / (low_ - part < 0 ? 1 - part : 1 + part);
    wide.slope_ = (slope_ + off_plane / least_) / (1 - part);
    return wide;
  }

  bool valid() const { return least_ > 0 && std::isfinite(slope_) && low_ <= high_; }
  double least() const { return least_; }
  double slope() const { return slope_; }
  const Vec3& axis() const { return axis_; }
  // The outermost directions in the plane, clockwise and counter-clockwise; not unit.
  Vec3 Low() const { return axis_ + low_ * side_; }
  Vec3 High() const { return axis_ + high_ * side_; }

 private:
  Vec3 normal_;
  Vec3 axis_;
  Vec3 side_;
  double least_ = std::numeric_limits<double>::infinity();
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
  double slope_ = 0;
};

inline constexpr double kRightAngle = std::numbers::pi / 2;

// The angle between two unit vectors, exact also where it is small.
inline double AngleBetween(const Vec3& a, const Vec3& b) {
  return 2 * std::asin(std::min(1.0, 0.5 * Norm(a - b)));
}

// What follows for a piece of surface whose derivatives along u and v are in two cones.
struct ProjectedCone {
  Vec3 normal = {0, 0, 0};
  // Every product (derivative along u) x (derivative along v) makes at most this angle with
  // `normal`, and less than a right angle; a right angle or more: nothing is known.
  double angle = 4 * kRightAngle;
  // A step of length 1 in the parameters moves the projection along `normal` by at least this.
  double stretch = 0;

  bool valid() const { return angle < kRightAngle; }
};

// Let p and q be the angles of a pair's projections, psi the angle between these, in (0, pi) for
// all pairs if it is for the outermost. The product's part in the plane is at most (slope_u +
// slope_v) |p| |q|, that along the normal |p| |q| sin psi. The length of x p + y q is at least
// min(|p|, |q|) sqrt(1 - |cos psi|) |(x, y)|.
inline ProjectedCone ConeOf(const Vec3& normal, const DirectionCone& u, const DirectionCone& v) {
  ProjectedCone cone = {.normal = normal};
  if (!u.valid() || !v.valid()) return cone;
  const auto sine = [&](const Vec3& a, const Vec3& b) {
    return Dot(normal, Cross(a, b)) / std::sqrt(Dot(a, a) * Dot(b, b));
  };
  // Neither cone is as wide as pi, so that psi stays in (0, pi) if these three say so.
  const double narrow = sine(u.High(), v.Low());
  const double wide = sine(u.Low(), v.High());
  const double least = std::min(narrow, wide);
  if (!(least > 0 && sine(u.axis(), v.axis()) > 0)) return cone;
  const double cosine = std::sqrt(std::max(0.0, 1 - least * least));
  cone.angle = std::atan((u.slope() + v.slope()) / least);
  cone.stretch = std::min(u.least(), v.least()) * std::sqrt(1 - cosine);
  return cone;
}

// The same where all directions are known, and no wider than it need be: those of the hulls of u
// and v have products in the convex cone of the products of these. The length of x p + y q, in the
// plane, is at least |(x, y)| times the smaller singular value of (p, q), which grows with |p x q|
// and falls with |p|^2 + |q|^2.
class ProductCone {
 public:
  explicit ProductCone(const Vec3& normal) : normal_(normal) {}

  // The directions of a piece of surface.
  template <class Directions>
  void Add(const Directions& u, const Directions& v) {
    double least = std::numeric_limits<double>::infinity();
    double longest_u = 0;
    double longest_v = 0;
    for (const Vec3& a : u) {
      longest_u = std::max(longest_u, Dot(a, a));
      for (const Vec3& b : v) {
        const Vec3 product = Cross(a, b);
        const double up = Dot(product, normal_);
        const Vec3 across = product - up * normal_;
        least = std::min(least, up);
        // Meaningless, but not asked for, where something points down.
        steepest_ = std::max(steepest_, Dot(across, across) / (up * up));
      }
    }
    for (const Vec3& b : v) longest_v = std::max(longest_v, Dot(b, b));
    const double squares = longest_u + longest_v;
    const double apart = std::sqrt(std::max(0.0, squares * squares - 4 * least * least));
    stretch_ = std::min(stretch_, least * std::sqrt(2 / (squares + apart)));
  }

  // Of all pieces that were added.
  ProjectedCone Cone() const {
    ProjectedCone cone = {.normal = normal_};
    if (!(stretch_ > 0) || !std::isfinite(steepest_)) return cone;
    cone.angle = std::atan(std::sqrt(steepest_));
    cone.stretch = stretch_;
    return cone;
  }

 private:
  Vec3 normal_;
  // The square of the tangent.
  double steepest_ = 0;
  double stretch_ = std::numeric_limits<double>::infinity();
};

}  // namespace limn
