// SPDX-License-Identifier: MIT
// The distances between the coarsest tessellations, for engine/limit/chord_bound.h.
//
// T^1 to T^2: both are made of quads with known vertices; the argument of chord_bound.h holds with
// T^2 in the place of S.
//
// T^0 to T^1, face by face: the face is a polygon P, split into triangles in any way, and a fan of
// quads of T^1 with the points E of P's edges and the point C of the face. Let n be the average
// normal of P, and let P be convex along it with C inside. Every triangle of P is at heights within
// P's. Let r be the range of the heights of P, E and C, and s the largest distance of an E to its
// edge. A point of the fan is a mean of P, E and C, so within s of one of P, the nearest points of
// edges to E, and C, which lies above or below P: it is at most s + r from P's triangles. The other
// way: a point of P that is further than s from P's outline, along n, lies above or below the fan,
// whose outline is within s of P's; a nearer one is within s + r of a point of an edge, which is
// within s of the fan's outline. So r + 2 s bounds both. Where P is not convex, or C not inside, P,
// E and C lie in a ball: its diameter bounds both.
#pragma once

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/refine/boundary_curve.h"
#include "engine/refine/doo_sabin_refine.h"

namespace limn {

struct CoarseSurface {
  // T^0 and T^1.
  const HalfEdgeMesh& base;
  const HalfEdgeMesh& split;
  // Of T^0.
  const ExtraordinaryFans& fans;
  // M^2.
  absl::Span<const Vec3> corners;
  const BoundaryCurve& boundary;
};

struct CoarseChords {
  double polygons_to_first = 0;
  double first_to_second = 0;
};

// Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: a pass over T^2's vertices and T^1's quads. Same bits
// for any number of threads.
[[nodiscard]] absl::StatusOr<CoarseChords> BoundCoarseLevels(const Context& context,
                                                             const CoarseSurface& surface);

}  // namespace limn
