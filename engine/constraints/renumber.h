// SPDX-License-Identifier: MIT
// Constraints of a mesh as those of the mesh that repair made of it.
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/constraints/constraints.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// What holds for a vertex holds for every vertex that comes from it. constraints: as
// ValidateConstraints accepts them for the input. original_vertex: for each vertex of the repaired
// mesh the input vertex that it comes from (RepairedMesh::original_vertex). Errors: INVALID_OPTION,
// with the field's path, for a vertex that repair has left out. Cost: n log n in the vertices, and
// logarithmic for each constraint. Thread-safe.
[[nodiscard]] absl::StatusOr<Constraints> RenumberConstraints(
    const Constraints& constraints, absl::Span<const Index> original_vertex);

}  // namespace limn
