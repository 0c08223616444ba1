// SPDX-License-Identifier: MIT
// The mesh cut along its plane faces. Source: Xu and Kondo, section 3.2.2: what surrounds a plane
// face is an open surface that ends at the face's edges.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// T^0 with every plane face a component of its own: the same faces and corners; vertices of plane
// faces are there once for each run of faces between two cut edges, first those of T^0, each for
// one of its runs, then the others. plane: one per face of mesh, which is from HalfEdgeMesh::Build.
// Errors: LIMIT_EXCEEDED, CANCELLED, DEADLINE_EXCEEDED. Cost: as HalfEdgeMesh::Build. Same result
// for any number of threads.
[[nodiscard]] absl::StatusOr<HalfEdgeMesh> CutAlongPlanes(const Context& context,
                                                          const HalfEdgeMesh& mesh,
                                                          absl::Span<const std::uint8_t> plane);

}  // namespace limn
