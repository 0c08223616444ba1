// SPDX-License-Identifier: MIT
// Smoothing of M^1 by conjugate gradients on weighted second differences; see
// engine/constraints/fair.h for the sum that is made small.
//
//             next o---o . .     W = corner h. Leaving direction: next, W, across = the corner
//                  | F |  E      counter-clockwise of h, beyond the edge that enters. Entering
//   across o . . . W---o prev    direction: prev, W, and the corner clockwise of h, beyond the edge
//            E     :             that leaves. At a boundary the corner across is W's ghost
//                  . clockwise   2 B - W.
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/fair_faces.h"

namespace limn {

// Takes `sweeps` steps, or fewer when nothing is left to gain. corners: M^1, changed in place; what
// `faces` keeps is kept but for the planes of faces that may turn: see FairFaces::Settle. Errors:
// CANCELLED, DEADLINE_EXCEEDED. Cost: two passes over corners a sweep; 216 bytes a corner. Same
// bits for any number of threads.
[[nodiscard]] absl::Status SmoothCorners(const Context& context, const FairFaces& faces, int sweeps,
                                         absl::Span<Vec3> corners);

}  // namespace limn
