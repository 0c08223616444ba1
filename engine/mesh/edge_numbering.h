// SPDX-License-Identifier: MIT
// Numbers edges in the order of their first half-edges, the order that every mesh of Limn uses.
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// Fills edge (per half-edge) and edge_half_edge (per edge) from twin. edge_half_edge is grown to
// its largest possible size, edge_bound, and then cut. Errors: CANCELLED, DEADLINE_EXCEEDED.
// Cost: two passes over twin and one over edges.
[[nodiscard]] absl::Status NumberEdges(const Context& context, absl::Span<const Index> twin,
                                       std::size_t edge_bound, Buffer<Index>* edge,
                                       Buffer<Index>* edge_half_edge);

}  // namespace limn
