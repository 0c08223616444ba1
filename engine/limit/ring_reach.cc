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

// Bezier points of a B-spline's segment.
CurvePoints BezierOf(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {0.5 * (a + b), b, 0.5 * (b + c)};
}

// A lower bound of the distance of the points' hull from the origin.
double DistanceOf(const CurvePoints& curve) {
  const Vec3 direction = NormalizedOrZero(curve[0] + curve[1] + curve[2]);
  return std::max(0.0, std::min({Dot(curve[0], direction), Dot(curve[1], direction),
                                 Dot(curve[2], direction)}));
}

// The sides u = 1 and v = 1 of a patch.
CurvePoints SideOfU(const BiquadraticNet& net) {
  const auto middle = [&](std::size_t j) { return 0.5 * (net[j][1] + net[j][2]); };
  return BezierOf(middle(0), middle(1), middle(2));
}
CurvePoints SideOfV(const BiquadraticNet& net) {
  const auto middle = [&](std::size_t i) { return 0.5 * (net[1][i] + net[2][i]); };
  return BezierOf(middle(0), middle(1), middle(2));
}

// The largest distance of a patch's Bezier points from the origin.
double RadiusOf(const BiquadraticNet& net) {
  const CurvePoints low = BezierOf(net[0][0], net[0][1], net[0][2]);
  const CurvePoints middle = BezierOf(net[1][0], net[1][1], net[1][2]);
  const CurvePoints high = BezierOf(net[2][0], net[2][1], net[2][2]);
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (const Vec3& p : BezierOf(low[i], middle[i], high[i])) largest = std::max(largest, Norm(p));
  }
  return largest;
}

}  // namespace

void RingReach::AddGeneration(const RingRefiner& refiner) {
  radius_.push_back(RadiusOf(refiner));
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sectors_; ++i) {
    const RefinedGrid grid = frame_.Projected(refiner.grid(i));
    for (const CurvePoints& side :
         {SideOfU(QuarterNet(grid, 0, 1)), SideOfU(QuarterNet(grid, 1, 1)),
          SideOfV(QuarterNet(grid, 1, 0)), SideOfV(QuarterNet(grid, 1, 1))}) {
      nearest = std::min(nearest, DistanceOf(side));
    }
  }
  clear_.push_back(nearest);
}

void RingReach::Finish(const RingRefiner& first, double slide) {
  double rest = RadiusOf(first) + frame_.stretch() * slide;
  for (std::size_t g = radius_.size(); g-- > 0;) {
    rest = std::max(radius_[g], 0.5 * rest);
    radius_[g] = rest;
  }
}

bool RingReach::Holds(int outer, int inner) const {
  return std::ldexp(radius_[static_cast<std::size_t>(inner)], outer - inner) <
         kLess * clear_[static_cast<std::size_t>(outer)];
}

// Of the quarters of the next generation.
double RingReach::RadiusOf(const RingRefiner& refiner) const {
  double largest = 0;
  for (std::size_t i = 0; i < sectors_; ++i) {
    const RefinedGrid grid = frame_.Projected(refiner.grid(i));
    for (std::size_t quarter = 1; quarter < 4; ++quarter) {
      largest = std::max(largest, limn::RadiusOf(QuarterNet(grid, quarter / 2, quarter % 2)));
    }
  }
  return largest;
}

}  // namespace limn
