// SPDX-License-Identifier: MIT
// Catmull-Clark and Loop surfaces at a parameter by nothing but many refinements of the faces
// around it. After each of them what is left is moved to the origin and doubled, so that
// differences keep all digits.
#pragma once

#include "engine/limit/evaluate.h"
#include "tests/oracle/creased.h"

namespace limn::oracle {

struct FollowedPoint {
  Point point;
  // Differences of the last face's points along u and v, in the parameters given.
  Point du;
  Point dv;
};

// mesh: T^0. blend: of the first step. steps: refinements after which the face is taken for flat,
// with errors like 4^-steps of the point and 2^-steps of its derivatives.
FollowedPoint Follow(const CreasedMesh& mesh, Rule rule, const SurfaceParameter& parameter,
                     int steps, Real blend = 0);

}  // namespace limn::oracle
