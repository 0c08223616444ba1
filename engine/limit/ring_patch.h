// SPDX-License-Identifier: MIT
// The patch of a control point at any parameter, in closed form: Doo-Sabin refinement of its ring
// is linear with known eigenvalues, so the net k refinements later is written down without making
// those before. Sources: Doo and Sabin 1978 (the spectrum); Stam, "Exact evaluation of
// Catmull-Clark subdivision surfaces at arbitrary parameter values", 1998 (the idea).
#pragma once

#include "engine/limit/control_ring.h"
#include "engine/limit/patch_sample.h"

namespace limn {

// u, v: in [0, 1], denormal numbers too. Nothing is divided by a small number, and the net is kept
// relative to the centroid of the face that it shrinks to, so that derivatives and normals are as
// exact near that centroid as anywhere; see engine/limit/evaluate.h for what they are at it. Cost:
// constant. Thread-safe.
PatchSample EvaluateRing(const ControlRing& ring, double u, double v);

}  // namespace limn
