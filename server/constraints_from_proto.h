// SPDX-License-Identifier: MIT
// Maps a job's constraints to what the engine takes: their structure. Whether they make sense for
// the mesh is checked by ValidateConstraints, when there is one.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "engine/constraints/constraints.h"
#include "limn/v1/constraints.pb.h"

namespace limn {

// vertex_count: what the header claims, 0 for no claim. Each list has at most one entry per vertex,
// so longer ones are refused before anything is copied.
//
// Errors, by the field's path in the contract's words: UNIMPLEMENTED for the kinds that are not
// built; INVALID_OPTION for a list that is too long, for a normal that is missing and for a kind of
// face that is none. Cost: linear in the constraints. Thread-safe.
[[nodiscard]] absl::StatusOr<Constraints> ConstraintsFromProto(const v1::Constraints& constraints,
                                                               std::uint64_t vertex_count);

// Bytes that such constraints take.
[[nodiscard]] std::uint64_t ConstraintBytes(const Constraints& constraints);

}  // namespace limn
