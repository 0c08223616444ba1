// SPDX-License-Identifier: MIT
// Draco bytes -> meshes and tiles: what draco_encoder.h makes, and plain triangle meshes of other
// programs.
#pragma once

#include <string_view>

#include "absl/status/statusor.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"
#include "proto/wire/draco_header.h"

namespace limn::wire {

struct DracoOutput {
  // Positions and polygons; faces name local vertex numbers, all in range.
  PolygonMesh mesh;
  // One per vertex, or none.
  Buffer<Vec3> normals;
  // Number that each vertex is known by, ascending and distinct. Empty when the bytes hold none,
  // or when they are 0, 1, 2 ...
  Buffer<Index> original_ids;
};

// Decodes. With an "original_id" attribute, points of one id become one vertex and vertices are in
// the order of their ids; without, the values of the position attribute are the vertices. Polygons
// are rebuilt from "limn.arities" (then triangles have to be fans) or from "added_edges".
// Attributes that are not named here are decoded by Draco and dropped.
//
// Errors: MALFORMED_ENCODING; LIMIT_EXCEEDED when the claims are above the bounds. Exceptions are
// the caller's. Cost: linear in the header's claims, which the number of bytes has to justify.
//
// CANCELLED and DEADLINE_EXCEEDED are seen between the parts of the work. What cannot be
// interrupted at a million vertices: 40 ms with the sequential coder; with edgebreaker 0.3 s while
// Draco decodes the connectivity, and 0.1 to 0.2 s for each attribute.
[[nodiscard]] absl::StatusOr<DracoOutput> DecodeDraco(const Context& context,
                                                      std::string_view bytes,
                                                      const DracoBounds& bounds);

}  // namespace limn::wire
