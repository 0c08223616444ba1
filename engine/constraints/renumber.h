// SPDX-License-Identifier: MIT
// Constraints of a mesh as those of the mesh that repair made of it.
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/constraints/constraints.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// What holds for a vertex or a face holds for all that come from it; a crease's vertices must not
// have become several. constraints: as
// ValidateConstraints accepts them for the input. original_vertex: for each vertex of the repaired
// mesh the input vertex that it comes from (RepairedMesh::original_vertex); original_face likewise.
// Errors: INVALID_OPTION, with the field's path, for a vertex that repair has left out, and for a
// crease's vertex that it has split; INDEX_OUT_OF_RANGE for creases, corners and holes at vertices
// and faces that are not there. Cost: n log n in the vertices, and
// logarithmic for each constraint. Thread-safe.
[[nodiscard]] absl::StatusOr<Constraints> RenumberConstraints(
    const Constraints& constraints, absl::Span<const Index> original_vertex,
    absl::Span<const Index> original_face);

}  // namespace limn
