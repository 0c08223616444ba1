// SPDX-License-Identifier: MIT
// Moves the images of each interpolated vertex so that the surface passes through the given point,
// whatever the solve left over, with the normal and the shape handle that are asked for. Sources:
// Zheng and Cai 2005, section 3.3, Eqs. 8 to 17, and section 4; Brunet 1988 (shape handles).
#pragma once

#include <algorithm>
#include <cstddef>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/refine/average_normal.h"
#include "engine/refine/boundary_curve.h"

namespace limn {

struct PerturbTask {
  // T^0.
  const HalfEdgeMesh& mesh;
  // The points to interpolate, one per vertex.
  absl::Span<const Vec3> points;
  // What is asked of each vertex. Null: all are interpolated, nothing else.
  const VertexPlan* plan = nullptr;
  // The boundary of `mesh`, changed in place. Null or empty for closed meshes. points and corners
  // are relative to its origin.
  BoundaryCurve* boundary = nullptr;
};

// For each interpolated vertex v: moves the points of its type-V face by the smallest amount [ZC
// Eq. 9] that puts their centroid on points[v] [Eq. 8] and all of them into the plane [Eqs. 11, 17]
// of the prescribed normal, or of their average normal [Eq. 10]. Where the average normal is zero
// they are only translated. Where the prescribed one lies in the plane of the face, within 1e-3
// rad, so that the face would collapse to a line, the face is turned about its centroid onto the
// prescribed plane instead, as in Nasri 1991; a face without any area is only projected, and the
// surface may have no tangent plane there (faces of two points are such; see
// ValidateDooSabinNormals). Then, interpolated or not, the shape handle scales the
// face about its centroid.
//
// On a boundary the centroid is the curve's point, ghosts move with their corners, and the curve
// itself is left as it is, to the bit, unless a normal or a handle is prescribed there: both turn
// and scale the curve's points near the vertex with the rest of the face. A normal perpendicular to
// the curve leaves it as it is up to rounding.
//
// corners: M^1, one per half-edge, changed in place. Afterwards the centroids are the points up to
// rounding (a few units in the last place of the largest coordinate around). Opposite prescribed
// normals give the same bits. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over corners.
// Same bits for any number of threads. Thread-safe.
[[nodiscard]] absl::Status PerturbToInterpolate(const Context& context, const PerturbTask& task,
                                                absl::Span<Vec3> corners);

}  // namespace limn
