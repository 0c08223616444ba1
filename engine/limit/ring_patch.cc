// SPDX-License-Identifier: MIT
#include "engine/limit/ring_patch.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/limit/biquadratic.h"
#include "engine/limit/shrinking_ring.h"
#include "engine/refine/doo_sabin_rule.h"

namespace limn {
namespace {

using Which = FaceAtCorner::Which;

Vec3 TimesPowerOfTwo(const Vec3& a, int exponent) {
  return {std::ldexp(a.x, exponent), std::ldexp(a.y, exponent), std::ldexp(a.z, exponent)};
}

// The net of the patch's quarter (i, j), other than (0, 0), of the ring after k refinements: part
// of the 4 x 4 points after one more, without the corner of `near`, relative to the centroid of
// `near` and times 2^(k + 1). For k = 0 the quarter (1, 1) needs a regular `far`.
BiquadraticNet QuarterNet(const ControlRing& ring, int k, std::size_t i, std::size_t j) {
  const ShrinkingRing shrinking(ring);
  const RingPoints p = shrinking.At(k);
  const RingPoints q = shrinking.At(k + 1);
  std::array<std::array<Vec3, 4>, 4> grid = {};
  grid[0] = {Vec3{0, 0, 0}, q.previous, q.below_right,
             2 * QuadImage(p.below_right, p.right, p.previous, p.own)};
  grid[1] = {q.next, q.own, q.right, 2 * QuadImage(p.right, p.own, p.below_right, p.previous)};
  grid[2] = {q.above_left, q.above, q.diagonal, Vec3{0, 0, 0}};
  grid[3] = {2 * QuadImage(p.above_left, p.above, p.next, p.own),
             2 * QuadImage(p.above, p.own, p.above_left, p.next), Vec3{0, 0, 0}, Vec3{0, 0, 0}};
  if (k == 0 && !ring.far.regular()) {
    grid[2][3] = 2 * (ring.far.Image(Which::kNext) - ring.near.centre());
    grid[3][2] = 2 * (ring.far.Image(Which::kPrevious) - ring.near.centre());
  } else {
    grid[2][3] = 2 * QuadImage(p.right, p.own, p.diagonal, p.above);
    grid[3][2] = 2 * QuadImage(p.above, p.own, p.diagonal, p.right);
    grid[3][3] = 2 * QuadImage(p.diagonal, p.right, p.above, p.own);
  }
  BiquadraticNet net;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      net[row][column] = grid[j + row][i + column];
    }
  }
  return net;
}

double Size(const ControlRing& ring) {
  return std::max(MaxAbs(ring.near.centre()), MaxAbs(ring.far.centre()));
}

PatchSample RegularSample(const ControlRing& ring, double u, double v) {
  const BiquadraticJet jet =
      EvaluateBiquadratic({{{ring.near.opposite, ring.previous(), ring.below_right},
                            {ring.next(), ring.own(), ring.right()},
                            {ring.above_left, ring.above(), ring.far.opposite}}},
                          u, v);
  return {jet.point, jet.du, jet.dv, UnitCross(jet.du, jet.dv, Size(ring))};
}

// At (0, 0): derivatives along the sides v = 0 and u = 0.
PatchSample CentreSample(const FaceAtCorner& near) {
  const Harmonics& f = near.harmonics;
  return {f.mean, near.first[Which::kOwn] + near.first[Which::kPrevious],
          near.first[Which::kOwn] + near.first[Which::kNext],
          UnitCross(f.t1, f.t2, static_cast<double>(near.sides) * MaxAbs(f.mean))};
}

// Anywhere but in the quarter at an extraordinary `far`.
PatchSample NearSample(const ControlRing& ring, double u, double v) {
  if (u == 0 && v == 0) return CentreSample(ring.near);
  // Refinements after which (u, v) is outside of the quarter at (0, 0).
  int exponent = 0;
  std::frexp(std::max(u, v), &exponent);
  const int k = std::max(0, -exponent);
  const double s = std::ldexp(u, k + 1);
  const double t = std::ldexp(v, k + 1);
  // Points between two quarters belong to the one that is regular for certain.
  const bool right = s > 1 || (s == 1 && t <= 1);
  const bool above = t > 1 || !right;
  const BiquadraticJet jet =
      EvaluateBiquadratic(QuarterNet(ring, k, right, above), s - right, t - above);
  return {ring.near.centre() + TimesPowerOfTwo(jet.point, -k - 1), jet.du, jet.dv,
          UnitCross(jet.du, jet.dv, Size(ring))};
}

}  // namespace

PatchSample EvaluateRing(const ControlRing& ring, double u, double v) {
  if (ring.near.regular() && ring.far.regular()) return RegularSample(ring, u, v);
  if (u <= 0.5 || v <= 0.5) return NearSample(ring, u, v);
  PatchSample sample = NearSample(HalfTurned(ring), 1 - u, 1 - v);
  sample.du = -sample.du;
  sample.dv = -sample.dv;
  return sample;
}

}  // namespace limn
