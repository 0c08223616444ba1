// SPDX-License-Identifier: MIT
// Polygons <-> triangles, for Draco, which knows triangles only. Two ways: fans, whose arities
// travel beside them, and triangles with a mark at the corners opposite to added edges.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::wire {

// Faces without points: as in PolygonMesh.
struct PolygonView {
  std::size_t vertex_count = 0;
  absl::Span<const Index> face_begin;
  absl::Span<const Index> corner_vertex;

  std::size_t face_count() const { return face_begin.size() - 1; }
  std::size_t arity(std::size_t f) const { return face_begin[f + 1] - face_begin[f]; }
  absl::Span<const Index> face(std::size_t f) const {
    return corner_vertex.subspan(face_begin[f], arity(f));
  }
  // Triangles that the faces fall into.
  std::size_t triangle_count() const { return corner_vertex.size() - 2 * face_count(); }
};

struct Polygons {
  Buffer<Index> face_begin;
  Buffer<Index> corner_vertex;
};

struct MarkedTriangles {
  // Three per triangle.
  Buffer<Index> corner_vertex;
  // Per corner: 1 when the edge opposite to it was added. One of an added edge's two opposite
  // corners is marked. Empty when no edge was added.
  Buffer<std::uint8_t> added;
};

// Fans from each face's first corner, face by face: (v0, v1, v2), (v0, v2, v3) ...
[[nodiscard]] Buffer<Index> FanTriangles(const PolygonView& faces);

// The polygons of FanTriangles. arities: 3 or more each (checked), sum of arities - 2 the number
// of triangles (checked). Errors: MALFORMED_ENCODING.
[[nodiscard]] absl::StatusOr<Polygons> PolygonsFromFans(absl::Span<const Index> triangles,
                                                        absl::Span<const Index> arities);

// Triangles such that every added edge joins two vertices that no other edge joins, given or
// added; without that an added edge could not be told from the other one afterwards.
//
// Errors, with field "faces" and the face's index: REPEATED_VERTEX; NON_MANIFOLD_EDGE when two
// faces walk an edge in the same direction; INVALID_OPTION when a face cannot be cut so (searched
// for completely up to 128 corners, with fans from 128 corners above). The remedy is a lossless
// encoding. CANCELLED and DEADLINE_EXCEEDED, seen at every face. Cost: linear, apart from that
// search, which takes the cube of a face's corners. Throws std::bad_alloc.
[[nodiscard]] absl::StatusOr<MarkedTriangles> TriangulateMarked(const Context& context,
                                                                const PolygonView& faces);

// Joins triangles over their marked edges. Every triangle is part of exactly one polygon without
// holes (checked). Faces come in the order of their first triangle. Errors: MALFORMED_ENCODING.
// CANCELLED, DEADLINE_EXCEEDED. Cost: linear. Throws std::bad_alloc.
[[nodiscard]] absl::StatusOr<Polygons> JoinMarked(const Context& context,
                                                  absl::Span<const Index> triangles,
                                                  absl::Span<const std::uint8_t> added);

}  // namespace limn::wire
