// SPDX-License-Identifier: MIT
// Creases, sharp corners and holes as constraints of a job: their sharpness on the given mesh.
// Source: engine/scheme/sharpness.h.
#pragma once

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/constraints/constraints.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/scheme/sharpness.h"

namespace limn {

// Errors: as MakeSharpness, with the field's path in the contract's words, such as
// "constraints.creases[2].vertices[3]"; INVALID_OPTION for creases of fewer than two vertices and
// for numbers of sharpnesses that do not fit. Cost: as MakeSharpness. Thread-safe.
[[nodiscard]] absl::StatusOr<Sharpness> SharpnessOf(const Context& context,
                                                    const HalfEdgeMesh& mesh,
                                                    const Constraints& constraints,
                                                    BoundaryRule boundary);

}  // namespace limn
