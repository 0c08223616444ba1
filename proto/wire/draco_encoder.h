// SPDX-License-Identifier: MIT
// Meshes and tiles -> Draco bytes. The draco::Mesh is built directly: Draco's own OBJ reader and
// writer merge and reorder.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "proto/wire/quantization_grid.h"
#include "proto/wire/triangulation.h"

namespace limn::wire {

// What is encoded. Indices are in range and arities 3 or more.
struct DracoInput {
  PolygonView faces;
  // One per vertex.
  absl::Span<const Vec3> positions;
  // One per vertex, or none.
  absl::Span<const Vec3> normals;
  // Number that each vertex is known by. Empty: 0, 1, 2 ... Given numbers are written as two uint16
  // each, the low half first: for uint32, Draco's encoder counts symbols in a table as long as the
  // largest number, which for a small tile of a large surface costs more than all the rest.
  absl::Span<const Index> original_ids;
};

// Sequential coder, raw float64 positions and float32 normals: lossless, vertices and faces in
// order. Errors: LIMIT_EXCEEDED beyond Draco's sizes (2^31 vertices or corners); ISOLATED_VERTEX
// when there are more vertices than triangle corners, which Draco would not read; INTERNAL;
// CANCELLED and DEADLINE_EXCEEDED, seen between the parts of the work, of which none takes longer
// than 50 ms at a million vertices. Exceptions are the caller's. Cost: linear.
[[nodiscard]] absl::StatusOr<std::string> EncodeDracoLossless(const Context& context,
                                                              const DracoInput& input);

// Edgebreaker, positions on the grid, original ids always written. Errors: those of
// TriangulateMarked; ISOLATED_VERTEX (field "vertices") for a vertex that no face uses, which
// edgebreaker does not keep; LIMIT_EXCEEDED; INTERNAL; CANCELLED and DEADLINE_EXCEEDED, seen before
// Draco runs and between its connectivity and attributes, each of which takes half a second at a
// million vertices. Exceptions are the caller's. Cost: linear, apart from the search of
// TriangulateMarked.
[[nodiscard]] absl::StatusOr<std::string> EncodeDracoQuantized(const Context& context,
                                                               const DracoInput& input,
                                                               const QuantizationGrid& grid,
                                                               int bits);

}  // namespace limn::wire
