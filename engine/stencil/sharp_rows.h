// SPDX-License-Identifier: MIT
// Limit stencil rows of vertices around which creases end, run or wear off, or that are sharp
// themselves, for Catmull-Clark and Loop.
//
// The ring of T^(k+1) around a vertex follows from that of T^k (V, the ends E_i of its edges, the
// vertices F_i across its quads, or at first the centroids of its faces). Once nothing around the
// vertex wears off any more, the masks of engine/limit/limit_masks.h give its limit point. Here
// these masks are taken back, refinement by refinement, to weights of the ring of T^0.
// Sources: DeRose, Kass and Truong 1998 (the rules); Halstead, Kass and DeRose 1993 (limit points
// as rows of an interpolation problem).
#pragma once

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/limit/limit_masks.h"
#include "engine/scheme/sharpness.h"
#include "engine/stencil/limit_stencil.h"

namespace limn {

// The rows of all vertices inside the mesh that are sharp or have a sharp edge.
// level: T^0, from HalfEdgeMesh::Build, of triangles for kTriangles; its sharpness. bilinear: share
// of the bilinear rule in the first refinement, see RefineCatmullClark; 0 for triangles.
// Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: a pass over vertices, and ten passes over the
// half-edges around sharp ones at the most. Same result for any number of threads.
[[nodiscard]] absl::StatusOr<WeightedRows> SharpRows(const Context& context, RingKind kind,
                                                     const SurfaceLevel& level, double bilinear);

}  // namespace limn
