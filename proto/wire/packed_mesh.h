// SPDX-License-Identifier: MIT
// MESH_ENCODING_PACKED: positions, arities and corner vertices, little-endian, without padding.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::wire {

// Sizes of a mesh, as claimed or as counted. Each below 2^32.
struct MeshCounts {
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  std::uint64_t corners = 0;
};

// Bytes of a packed mesh. Cost: constant.
[[nodiscard]] std::uint64_t PackedBytes(const MeshCounts& counts);

// mesh: checked by CheckPolygons. Errors: OUT_OF_MEMORY is the caller's to catch; CANCELLED,
// DEADLINE_EXCEEDED. Cost: linear, in parallel.
[[nodiscard]] absl::StatusOr<std::string> EncodePacked(const Context& context,
                                                       const PolygonMesh& mesh);

// counts: held against the limits before. Errors: MALFORMED_ENCODING when the size of `bytes` or
// the arities do not fit the counts; CANCELLED, DEADLINE_EXCEEDED. Indices are left to
// CheckPolygons. Cost: linear, in parallel.
[[nodiscard]] absl::StatusOr<PolygonMesh> DecodePacked(const Context& context,
                                                       const MeshCounts& counts,
                                                       std::string_view bytes);

}  // namespace limn::wire
