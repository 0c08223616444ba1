// SPDX-License-Identifier: MIT
#include "engine/limit/shrinking_ring.h"

#include <cmath>

namespace limn {

using Which = FaceAtCorner::Which;

// The factors of the modes after k refinements, all points taken times 2^k.
struct ShrinkingRing::ModeFactors {
  ModeFactors(double e, int k)
      : first(e == 0.5 ? 1 : std::pow(2 * e, k)),
        quarter(std::ldexp(1, -k)),
        resonant(k * quarter),
        eighth(quarter * quarter),
        sixteenth(quarter * eighth) {}
  double first;
  double quarter;
  double resonant;
  double eighth;
  double sixteenth;
};

// own_side: beside `own`, and other_side beside `other`. By [ZC Eq. 1]
//   sum' = 3/4 (inner sum) + 1/4 sum,  difference' = 3/8 (inner difference) + 1/8 difference,
// which these factors solve for inner points with the modes first * e^k + rest / 4^k.
ShrinkingRing::EdgeModes::EdgeModes(const CornerModes& own, const CornerModes& other,
                                    const Vec3& own_side, const Vec3& other_side, double e)
    : sum_first(0.75 / (e - 0.25) * (own.first + other.first)),
      sum_quarter(own_side + other_side - sum_first),
      sum_resonant(3 * (own.rest + other.rest)),
      difference_first(0.375 / (e - 0.125) * (own.first - other.first)),
      difference_quarter(3 * (own.rest - other.rest)),
      difference_eighth(own_side - other_side - difference_first - difference_quarter) {}

Vec3 ShrinkingRing::EdgeModes::Sum(const ModeFactors& f) const {
  return f.first * sum_first + f.quarter * sum_quarter + f.resonant * sum_resonant;
}

Vec3 ShrinkingRing::EdgeModes::Difference(const ModeFactors& f) const {
  return f.first * difference_first + f.quarter * difference_quarter + f.eighth * difference_eighth;
}

ShrinkingRing::CornerModes ShrinkingRing::ModesOf(const FaceAtCorner& face, Which which) {
  return {.first = face.first[which], .rest = face.Rest(which)};
}

ShrinkingRing::ShrinkingRing(const ControlRing& ring)
    : e_(ring.near.subdominant()),
      own_(ModesOf(ring.near, Which::kOwn)),
      previous_(ModesOf(ring.near, Which::kPrevious)),
      next_(ModesOf(ring.near, Which::kNext)),
      leaving_(own_, previous_, ring.right() - ring.near.centre(),
               ring.below_right - ring.near.centre(), e_),
      entering_(own_, next_, ring.above() - ring.near.centre(),
                ring.above_left - ring.near.centre(), e_) {
  // The fourth point of `far`, if that is a quad; if not, the one that would give the same image
  // of `own`: from the first refinement on there is only a quad.
  const Vec3& centre = ring.near.centre();
  const Vec3 sides = (ring.right() - centre) + (ring.above() - centre);
  const Vec3 diagonal = ring.far.regular() ? ring.far.opposite - centre
                                           : 16 * (ring.far.Image(Which::kOwn) - centre) -
                                                 9 * (ring.own() - centre) - 3 * sides;
  // diagonal' = (9 own + 3 (right + above) + diagonal) / 16, and right + above is half of the sums
  // and differences of both edges.
  const Vec3 first = leaving_.sum_first + entering_.sum_first + leaving_.difference_first +
                     entering_.difference_first;
  const Vec3 quarter = leaving_.sum_quarter + entering_.sum_quarter + leaving_.difference_quarter +
                       entering_.difference_quarter;
  diagonal_first_ = 1 / (16 * e_ - 1) * (9 * own_.first + 1.5 * first);
  diagonal_resonant_ = 0.5 * (leaving_.sum_resonant + entering_.sum_resonant);
  diagonal_quarter_ = 3 * own_.rest + 0.5 * quarter - 4.0 / 3 * diagonal_resonant_;
  diagonal_eighth_ = 1.5 * (leaving_.difference_eighth + entering_.difference_eighth);
  diagonal_sixteenth_ = diagonal - diagonal_first_ - diagonal_quarter_ - diagonal_eighth_;
}

RingPoints ShrinkingRing::At(int k) const {
  const ModeFactors f(e_, k);
  const auto corner = [&](const CornerModes& modes) {
    return f.first * modes.first + f.quarter * modes.rest;
  };
  const Vec3 leaving_sum = leaving_.Sum(f);
  const Vec3 leaving_difference = leaving_.Difference(f);
  const Vec3 entering_sum = entering_.Sum(f);
  const Vec3 entering_difference = entering_.Difference(f);
  return {.previous = corner(previous_),
          .own = corner(own_),
          .next = corner(next_),
          .right = 0.5 * (leaving_sum + leaving_difference),
          .below_right = 0.5 * (leaving_sum - leaving_difference),
          .above = 0.5 * (entering_sum + entering_difference),
          .above_left = 0.5 * (entering_sum - entering_difference),
          .diagonal = f.first * diagonal_first_ + f.quarter * diagonal_quarter_ +
                      f.resonant * diagonal_resonant_ + f.eighth * diagonal_eighth_ +
                      f.sixteenth * diagonal_sixteenth_};
}

}  // namespace limn
