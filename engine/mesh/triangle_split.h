// SPDX-License-Identifier: MIT
// Connectivity of the split of every triangle into four (that of Loop refinement), as arithmetic on
// half-edge numbers.
// Source: Dupuy and Vanhoey, "A Halfedge Refinement Rule for Parallel Loop Subdivision", 2022, with
// the four triangles of each old one kept together; numbering as in engine/limit/tessellation.h.
//
// Triangle f becomes triangles 4f .. 4f + 3: one for each of its corners in corner order, then the
// middle one. So the corner h = 3f + i has the triangle T(h) = 4f + i = h + h / 3, with half-edges
//   3T: vertex -> edge(h),  3T + 1: edge(h) -> edge(prev h),  3T + 2: edge(prev h) -> vertex,
// and half-edge 3 (4f + 3) + i of the middle one runs edge(h) -> edge(next h).
//
//             v2                 Level k's triangles in triangle f of level 0 are
//            /  \                [4^k f, 4^k (f + 1)), and the triangle at corner i of f that
//          e2 -- e1              still has f's vertex comes first in its part.
//         /  \  /  \             e_i is the edge that leaves v_i.
//       v0 -- e0 -- v1
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// Ok when all faces are triangles. Error: INVALID_OPTION for field "mesh.faces", naming how many
// faces are not and the first of them. Cost: constant for a mesh of triangles, else a pass over
// faces.
[[nodiscard]] absl::Status RequireTriangles(const HalfEdgeMesh& mesh);

// The triangle of the split mesh that lies at corner h.
inline Index CornerTriangle(Index h) { return h + h / 3; }

// The split mesh: vertex_count() + edge_count() vertices numbered [old | edges], 4 face_count()
// triangles, arity() 3. Errors: as RequireTriangles; LIMIT_EXCEEDED when numbers would not fit 32
// bits; CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over the new half-edges, 13 bytes each.
// Same result for any number of threads. Thread-safe.
[[nodiscard]] absl::StatusOr<HalfEdgeMesh> SplitIntoTriangles(const Context& context,
                                                              const HalfEdgeMesh& mesh);

// Writes the vertices of the split mesh's triangles: 12 per triangle of `mesh`. Errors: as
// RequireTriangles; CANCELLED, DEADLINE_EXCEEDED.
[[nodiscard]] absl::Status TriangleVertices(const Context& context, const HalfEdgeMesh& mesh,
                                            absl::Span<Index> vertices);

}  // namespace limn
