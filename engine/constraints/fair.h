// SPDX-License-Identifier: MIT
// Takes overshoot out of a surface: with unequal edge lengths the images of a vertex reach further
// along a short edge than it is long, and the surface swings or folds there. Source: none; shape
// handles after Brunet 1988, planes after Zheng and Cai 2005, Eqs. 10, 11 and 17.
//
// Two cures, which move the points W of a type-V face about its centroid c only:
//   1. A shape handle per vertex: S = min(1, kappa / largest extent), where the extent of W along
//      an edge vector e of its corner, from limit point to limit point, is (W - c) . e / |e|^2. On
//      a regular mesh it is 1/4, so that kappa = 0.3 leaves such meshes as they are.
//   2. Smoothing: a few steps of conjugate gradients on the sum over all corners of
//        w |(W_beside - W) / a + (W_across - W) / b|^2,
//      once for each of the two edges e of the corner: W_beside is the image at the other end of e
//      in the same face, W_across the image of the same vertex beyond the other edge, e'. Were the
//      control points on straight lines at the distances a = |e| / 2 and b, half the harmonic mean
//      of |e| and the edge that goes on beyond the vertex, nothing would bend; w = |e'| / (a + b)
//      makes the term the square of the curvature along e, times an area. Steps are projected to
//      sum zero over each face, so that centroids stay; each face then gets the plane of its new
//      average normal, and a looser handle, kappa = 0.5, for smoothing may overshoot in its turn.
#pragma once

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

inline constexpr double kFairExtent = 0.3;
inline constexpr double kSmoothedExtent = 0.5;
inline constexpr int kFairSweeps = 8;

struct FairInput {
  // What was asked of each vertex. Null: all are interpolated, nothing else.
  const VertexPlan* plan = nullptr;
};

struct FairnessReport {
  // Bending energy (engine/limit/bending_energy.h) of the surface as it came and as it went.
  double energy_before = 0;
  double energy_after = 0;
  // Which cures were applied; none where they would not have lowered the energy.
  bool shape_handles = false;
  bool smoothing = false;
};

// Tries in turn the surface as it is, the first cure, and both; then what is best of these vertex
// by vertex (engine/constraints/fair_choice.h), since where a surface folds a cure may do harm that
// outweighs all its good; then that, smoothed once more; and the best of it vertex by vertex. Keeps
// the one with the lowest bending energy of all, the first of equals. So the energy never rises.
// What is left of it: 0.002 to 0.1 of surfaces that fold, as most do over random polygons; 0.6 to
// 0.9 of boxes whose edges are graded, the less the steeper, of which descent on the energy itself
// would leave four fifths at the best, at a thousand times the cost; all but 1e-4 of a round torus.
//
// surface: M^1 after PerturbToInterpolate with the same plan; its corners are changed, and only
// when all went well. Kept: the centroids of all type-V faces (so limit points at vertices) up to
// rounding; the plane of each face with a prescribed normal (within 1e-10 rad); all points of faces
// with a user's handle other than 1, and the boundary curve, to the bit. A
// face that is neither prescribed nor fixed stays plane if its vertex is interpolated, but its
// normal may change: holding it gains about half as much. On a boundary, only what a point is off
// its curve, W - B, is scaled; corners of the boundary are left to smoothing.
//
// Errors: LIMIT_EXCEEDED where numbers of T^1 do not fit, CANCELLED, DEADLINE_EXCEEDED. Progress:
// stage "fair". Cost: six measurements of the energy, which take most of it, and 2 kFairSweeps + 20
// passes over the corners; 400 bytes a corner beside the energy's. Same bits for any number of
// threads. Thread-safe.
[[nodiscard]] absl::StatusOr<FairnessReport> Fair(const Context& context, const FairInput& input,
                                                  DooSabinSurface* surface);

}  // namespace limn
