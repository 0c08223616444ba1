// SPDX-License-Identifier: MIT
// A polygon mesh as index arrays: the form in which meshes come in and go out. Nothing is checked
// here; HalfEdgeMesh::Build does that.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/vec3.h"

namespace limn {

// Number of a vertex, face, edge or half-edge.
using Index = std::uint32_t;

// No such element.
inline constexpr Index kNoIndex = ~Index{0};

// A corner is a place in `corner_vertex`; the corners of face f are
// [face_begin[f], face_begin[f + 1]), counter-clockwise seen from outside.
struct PolygonMesh {
  // One point per vertex, in model units.
  Buffer<Vec3> positions;
  // First corner of each face and, at the end, the number of corners. Empty when there are no
  // faces; otherwise face_count() + 1 elements that start at 0 and do not decrease.
  Buffer<Index> face_begin;
  // Vertex of each corner.
  Buffer<Index> corner_vertex;

  std::size_t vertex_count() const { return positions.size(); }
  std::size_t face_count() const { return face_begin.empty() ? 0 : face_begin.size() - 1; }
  std::size_t corner_count() const { return corner_vertex.size(); }
  std::size_t arity(std::size_t face) const { return face_begin[face + 1] - face_begin[face]; }
  absl::Span<const Index> face(std::size_t f) const {
    return absl::MakeConstSpan(corner_vertex).subspan(face_begin[f], arity(f));
  }
  // Appends a face. Cost: amortised constant per corner. Not for hot paths.
  void AddFace(absl::Span<const Index> vertices) {
    if (face_begin.empty()) face_begin.push_back(0);
    corner_vertex.insert(corner_vertex.end(), vertices.begin(), vertices.end());
    face_begin.push_back(static_cast<Index>(corner_vertex.size()));
  }

  friend bool operator==(const PolygonMesh& a, const PolygonMesh& b) = default;
};

}  // namespace limn
