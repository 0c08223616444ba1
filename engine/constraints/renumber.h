// SPDX-License-Identifier: MIT
// Constraints of a mesh as those of the mesh that repair made of it.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/constraints/constraints.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// What repair made of a mesh.
struct RepairOrigin {
  // For each vertex and face of the repaired mesh the input's that it comes from.
  absl::Span<const Index> vertex;
  absl::Span<const Index> face;
  // Of the input.
  std::size_t vertex_count = 0;
  std::size_t face_count = 0;
};

// What holds for a vertex or a face holds for all that come from it; of corners that name a vertex
// again the last one counts. A crease's vertices must not have become several.
// Repair may turn faces around, so that constraints at their parameters and regions of faces are
// refused. constraints: as
// ValidateConstraints accepts them for the input.
//
// Errors, with the field's path and the index in it: INVALID_OPTION for a vertex that repair has
// left out, for a crease's vertex that it has split, for parameters and regions, and for feature
// values of elements; INDEX_OUT_OF_RANGE for creases, corners and holes at vertices and faces that
// are not there; CANCELLED, DEADLINE_EXCEEDED. Cost: n log n in the vertices and in the
// constraints; the result names each vertex of the repaired mesh at most once for each kind, but in
// creases. Thread-safe.
[[nodiscard]] absl::StatusOr<Constraints> RenumberConstraints(const Context& context,
                                                              const Constraints& constraints,
                                                              const RepairOrigin& origin);

}  // namespace limn
