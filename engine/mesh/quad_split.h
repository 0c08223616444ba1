// SPDX-License-Identifier: MIT
// Connectivity of the split of every face of arity m into m quads (that of Catmull-Clark
// refinement, and of the dual of Doo-Sabin refinement), as arithmetic on half-edge numbers.
// Source: Dupuy and Vanhoey, "A Halfedge Refinement Rule for Parallel Catmull-Clark
// Subdivision", 2021, for meshes of any arity; numbering as in engine/limit/tessellation.h.
//
// Half-edge h of the mesh becomes quad h, with half-edges
//   4h: vertex -> edge(h),  4h + 1: edge(h) -> face,
//   4h + 2: face -> edge(prev h),  4h + 3: edge(prev h) -> vertex.
#pragma once

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// The split mesh: vertex_count() + edge_count() + face_count() vertices numbered [old | edges |
// faces], half_edge_count() quads. Errors: LIMIT_EXCEEDED when numbers would not fit 32 bits,
// CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over the new half-edges, 14 bytes each.
// Same result for any number of threads. Thread-safe.
[[nodiscard]] absl::StatusOr<HalfEdgeMesh> SplitIntoQuads(const Context& context,
                                                          const HalfEdgeMesh& mesh);

// Writes the vertices of the split mesh's quads: 4 per half-edge of `mesh`.
[[nodiscard]] absl::Status QuadVertices(const Context& context, const HalfEdgeMesh& mesh,
                                        absl::Span<Index> vertices);

}  // namespace limn
