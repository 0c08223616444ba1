// SPDX-License-Identifier: MIT
// Checks of index arrays and coordinates, and the words for what they find.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// Coordinates of larger magnitude are refused: their squares and products overflow.
inline constexpr double kMaxCoordinate = 1e100;
// Meshes whose bounding box is smaller, but not a point, are refused: their differences have too
// few bits left.
inline constexpr double kMinDiagonal = 1e-300;

// The remedy of what Repair (engine/mesh/repair.h) mends too. remedy: without a full stop.
[[nodiscard]] std::string OrRepair(std::string_view remedy);

// Axis-aligned box of points.
struct BoundingBox {
  Vec3 min = {0, 0, 0};
  Vec3 max = {0, 0, 0};
  // Also where the squares of the sides underflow.
  double diagonal() const {
    const Vec3 side = max - min;
    const double scale = MaxAbs(side);
    return scale > 0 ? scale * Norm({side.x / scale, side.y / scale, side.z / scale}) : 0;
  }
};

// Checks that all coordinates are finite and at most kMaxCoordinate in magnitude, and computes
// their box. Errors: NON_FINITE_COORDINATE, COORDINATE_TOO_LARGE (count and first vertex),
// EXTENT_TOO_SMALL, EMPTY_MESH, CANCELLED, DEADLINE_EXCEEDED. Cost: one pass.
[[nodiscard]] absl::Status ValidatePositions(const Context& context,
                                             absl::Span<const Vec3> positions, BoundingBox* box);

// Checks sizes against the context's limits, arities, index ranges and that no face visits a
// vertex twice. Errors: EMPTY_MESH, LIMIT_EXCEEDED, MALFORMED_REQUEST (face_begin not increasing),
// FACE_TOO_SMALL, INDEX_OUT_OF_RANGE, REPEATED_VERTEX. Cost: one pass.
[[nodiscard]] absl::Status ValidateFaces(const Context& context, const PolygonMesh& mesh);

// The part of ValidateFaces that no repair replaces: sizes, face_begin and index ranges; arities
// are free. Errors: EMPTY_MESH, LIMIT_EXCEEDED, MALFORMED_REQUEST, INDEX_OUT_OF_RANGE. Cost: one
// pass.
[[nodiscard]] absl::Status ValidateIndices(const Context& context, const PolygonMesh& mesh);

// A half-edge in the bucket of its end of smaller number.
struct EdgeUse {
  Index other_end;
  Index half_edge;
  friend auto operator<=>(const EdgeUse& a, const EdgeUse& b) = default;
};

// All half-edges by their end of smaller number: uses[begin[v] .. begin[v + 1]) are those of v, in
// any order.
struct EdgeBuckets {
  absl::Span<const Index> begin;
  absl::Span<const EdgeUse> uses;
};

// A mesh whose half-edges could not be paired: says why. mesh: as ValidateFaces accepts it. Errors:
// NON_MANIFOLD_EDGE, INCONSISTENT_ORIENTATION, CANCELLED, DEADLINE_EXCEEDED. Ok when every edge is
// well formed. Cost: sorts each bucket.
[[nodiscard]] absl::Status DiagnoseEdges(const Context& context, const PolygonMesh& mesh,
                                         const EdgeBuckets& buckets);

}  // namespace limn
