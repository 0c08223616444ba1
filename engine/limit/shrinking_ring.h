// SPDX-License-Identifier: MIT
// What becomes of a control point's ring as Doo-Sabin refinement shrinks it to the centroid of one
// of its faces, in closed form. Source: Doo and Sabin 1978 (eigenvalues of a face); the outer
// points follow from [ZC Eq. 1] for quads.
//
// Corners of `near` are its centroid + first harmonic * e^k + rest / 4^k after k refinements, with
// e = 1/2 (3/4 for two sides). The points around them are driven by these, with eigenvalues 1/4 and
// 1/8 of their own in the type-E faces and 1/16 of the diagonal's; 1/4 meets 1/4, hence a mode
// k / 4^k.
#pragma once

#include "engine/base/vec3.h"
#include "engine/limit/control_ring.h"

namespace limn {

// The ring's points, named as in engine/limit/control_ring.h, relative to the centroid of `near`.
struct RingPoints {
  Vec3 previous;
  Vec3 own;
  Vec3 next;
  Vec3 right;
  Vec3 below_right;
  Vec3 above;
  Vec3 above_left;
  Vec3 diagonal;
};

class ShrinkingRing {
 public:
  explicit ShrinkingRing(const ControlRing& ring);

  // The points after k >= 0 refinements, times 2^k. The diagonal only where `far` is a quad or
  // k >= 1. Cost: constant.
  RingPoints At(int k) const;

 private:
  struct ModeFactors;
  struct CornerModes {
    Vec3 first;
    Vec3 rest;
  };
  // The two outer points of a type-E face, by their sum and difference, which refine apart.
  struct EdgeModes {
    EdgeModes(const CornerModes& own, const CornerModes& other, const Vec3& own_side,
              const Vec3& other_side, double e);
    Vec3 Sum(const ModeFactors& f) const;
    Vec3 Difference(const ModeFactors& f) const;

    Vec3 sum_first;
    Vec3 sum_quarter;
    Vec3 sum_resonant;
    Vec3 difference_first;
    Vec3 difference_quarter;
    Vec3 difference_eighth;
  };
  static CornerModes ModesOf(const FaceAtCorner& face, FaceAtCorner::Which which);

  // The subdominant eigenvalue of `near`.
  double e_;
  CornerModes own_;
  CornerModes previous_;
  CornerModes next_;
  // The faces of the half-edges that leave and enter the corner.
  EdgeModes leaving_;
  EdgeModes entering_;
  Vec3 diagonal_first_;
  Vec3 diagonal_resonant_;
  Vec3 diagonal_quarter_;
  Vec3 diagonal_eighth_;
  Vec3 diagonal_sixteenth_;
};

}  // namespace limn
