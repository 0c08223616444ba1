// SPDX-License-Identifier: MIT
// The check that every path from and to bytes shares: do the index arrays of a mesh fit together?
#pragma once

#include "absl/status/status.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::wire {

// What the findings are called, and which arities pass.
struct PolygonRules {
  Reason face_too_small = Reason::kFaceTooSmall;
  Reason index_out_of_range = Reason::kIndexOutOfRange;
  Index least_arity = 3;
};

// How findings are called in bytes that were received.
inline constexpr PolygonRules kReceived = {Reason::kMalformedEncoding, Reason::kMalformedEncoding};

// Checks that there are vertices and faces, that face_begin runs from 0 to the number of corners in
// steps of the least arity or more, and that corners name vertices that are there. Errors (field
// "vertices" or "faces", the first bad face as index): EMPTY_MESH, and as `rules` says; CANCELLED,
// DEADLINE_EXCEEDED. Cost: linear, in parallel.
[[nodiscard]] absl::Status CheckPolygons(const Context& context, const PolygonMesh& mesh,
                                         const PolygonRules& rules = {});

}  // namespace limn::wire
