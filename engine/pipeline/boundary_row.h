// SPDX-License-Identifier: MIT
// The boundary rule of Catmull-Clark and Loop when control points are solved for: the limit curve
// is a cubic B-spline with sharp corners. Sources: Hoppe et al. 1994; DeRose, Kass and Truong 1998.
#pragma once

#include "engine/scheme/sharpness.h"
#include "engine/solve/control_mesh.h"

namespace limn {

// Fills corner and, where something is sharp for a while, vertex_weights of a problem whose curve
// is the boundary of level.mesh, which is T^0. A vertex has the weight 2/3 in its own limit point,
// more where it is sharp for a while, 1 at corners: by the boundary rule, by its own sharpness, or
// because something inside that is sharp for ever ends there. Cost: ten passes over the half-edges
// at the boundary at the most. Thread-safe.
void SetBoundaryRows(const SurfaceLevel& level, BoundaryProblem* boundary);

}  // namespace limn
