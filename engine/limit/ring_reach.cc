// SPDX-License-Identifier: MIT
#include "engine/limit/ring_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/limit/biquadratic.h"

namespace limn {
namespace {

// Room for rounding.
constexpr double kLess = 1 - 1e-9;

using CurvePoints = std::array<Vec3, 3>;
using PatchPoints = std::array<Vec3, 9>;

// Bezier points of a B-spline's segment.
CurvePoints BezierOf(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {0.5 * (a + b), b, 0.5 * (b + c)};
}
PatchPoints BezierOf(const BiquadraticNet& net) {
  std::array<CurvePoints, 3> row;
  for (std::size_t j = 0; j < 3; ++j) row[j] = BezierOf(net[j][0], net[j][1], net[j][2]);
  PatchPoints points{};
  for (std::size_t i = 0; i < 3; ++i) {
    const CurvePoints column = BezierOf(row[0][i], row[1][i], row[2][i]);
    for (std::size_t j = 0; j < 3; ++j) points[3 * j + i] = column[j];
  }
  return points;
}

// A lower bound of the distance of the points' hull from the origin.
template <class Points>
double DistanceOf(const Points& points) {
  Vec3 sum = {0, 0, 0};
  for (const Vec3& p : points) sum += p;
  const Vec3 direction = NormalizedOrZero(sum);
  double least = std::numeric_limits<double>::infinity();
  for (const Vec3& p : points) least = std::min(least, Dot(p, direction));
  return std::max(0.0, least);
}

template <class Points>
double RadiusOf(const Points& points) {
  double largest = 0;
  for (const Vec3& p : points) largest = std::max(largest, Norm(p));
  return largest;
}

}  // namespace

void RingReach::AddGeneration(const RingRefiner& refiner) {
  double radius = 0;
  double near = std::numeric_limits<double>::infinity();
  double clear = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sectors_; ++i) {
    const RefinedGrid grid = frame_.Projected(refiner.grid(i));
    for (std::size_t quarter = 1; quarter < 4; ++quarter) {
      const BiquadraticNet net = QuarterNet(grid, quarter / 2, quarter % 2);
      const PatchPoints points = BezierOf(net);
      radius = std::max(radius, RadiusOf(points));
      if (at_boundary_) near = std::min(near, DistanceOf(points));
      // The sides u = 1 and v = 1.
      if (quarter % 2 == 1) {
        clear = std::min(clear, DistanceOf(CurvePoints{points[2], points[5], points[8]}));
      }
      if (quarter / 2 == 1) {
        clear = std::min(clear, DistanceOf(CurvePoints{points[6], points[7], points[8]}));
      }
    }
  }
  radius_.push_back(radius);
  near_.push_back(near);
  clear_.push_back(clear);
}

void RingReach::Finish(const RingRefiner& first, double slide) {
  double rest = RadiusOfQuarters(first) + frame_.stretch() * slide;
  for (std::size_t g = radius_.size(); g-- > 0;) {
    rest = std::max(radius_[g], 0.5 * rest);
    radius_[g] = rest;
  }
}

bool RingReach::Holds(int outer, int inner) const {
  return std::ldexp(radius_[static_cast<std::size_t>(inner)], outer - inner) <
         kLess * clear_[static_cast<std::size_t>(outer)];
}

int RingReach::EndOfPaths(int g) const {
  const int size = static_cast<int>(radius_.size());
  if (g > size) return std::numeric_limits<int>::max();
  const double distance = kLess * near_[static_cast<std::size_t>(g - 1)];
  for (int e = g; e < size; ++e) {
    if (std::ldexp(radius_[static_cast<std::size_t>(e)], g - 1 - e) < distance) return e;
  }
  return std::numeric_limits<int>::max();
}

// Of the quarters of the next generation.
double RingReach::RadiusOfQuarters(const RingRefiner& refiner) const {
  double radius = 0;
  for (std::size_t i = 0; i < sectors_; ++i) {
    const RefinedGrid grid = frame_.Projected(refiner.grid(i));
    for (std::size_t quarter = 1; quarter < 4; ++quarter) {
      radius = std::max(radius, RadiusOf(BezierOf(QuarterNet(grid, quarter / 2, quarter % 2))));
    }
  }
  return radius;
}

}  // namespace limn
