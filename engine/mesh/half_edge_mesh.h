// SPDX-License-Identifier: MIT
// Connectivity of an oriented 2-manifold polygon mesh as flat half-edge arrays. Positions live
// elsewhere, in arrays indexed by its vertices, faces or corners.
// Source of the layout: Dupuy and Vanhoey, "A Halfedge Refinement Rule for Parallel Catmull-Clark
// Subdivision", 2021: half-edge h is the corner h of its face, so next and prev are arithmetic.
//
//            face(h)                     h leaves vertex(h) and ends in vertex(Next(h)).
//        o--- h ---->o                   twin(h) runs the other way in the neighbouring face,
//   vertex(h)  <-- twin(h) ---           or is kNoIndex on a boundary.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

class HalfEdgeMesh {
 public:
  // Builds and validates. Faces of any arity from 3 upwards, any number of components, with or
  // without boundary. Corners keep the order of mesh.corner_vertex.
  //
  // Errors, each naming kind, count and first offending element: EMPTY_MESH, FACE_TOO_SMALL,
  // INDEX_OUT_OF_RANGE, REPEATED_VERTEX, NON_MANIFOLD_EDGE, INCONSISTENT_ORIENTATION,
  // NON_MANIFOLD_VERTEX, ISOLATED_VERTEX (looked for in this order), LIMIT_EXCEEDED, CANCELLED,
  // DEADLINE_EXCEEDED. Positions are not looked at, only their number.
  //
  // Cost: linear in corners (times the logarithm of the valence at vertices above valence 32);
  // 28 bytes a corner at the peak. Same result for any number of threads. Thread-safe.
  [[nodiscard]] static absl::StatusOr<HalfEdgeMesh> Build(const Context& context,
                                                          const PolygonMesh& mesh);

  std::size_t vertex_count() const { return vertex_half_edge_.size(); }
  std::size_t edge_count() const { return edge_half_edge_.size(); }
  std::size_t half_edge_count() const { return vertex_.size(); }
  std::size_t face_count() const {
    return arity_ == 0 ? face_begin_.size() - 1 : vertex_.size() / arity_;
  }
  std::size_t boundary_edge_count() const { return 2 * edge_count() - half_edge_count(); }

  // Whether the mesh ends at vertex v.
  bool IsBoundary(std::size_t v) const { return twin_[vertex_half_edge_[v]] == kNoIndex; }

  // Arity of all faces, or 0 when it differs or the mesh comes from Build.
  std::uint32_t arity() const { return arity_; }

  // Vertex that each half-edge leaves.
  absl::Span<const Index> vertex() const { return vertex_; }
  // Opposite half-edge, or kNoIndex.
  absl::Span<const Index> twin() const { return twin_; }
  // Edge of each half-edge; edges are numbered by first occurrence along the half-edges.
  absl::Span<const Index> edge() const { return edge_; }
  // First half-edge of each edge.
  absl::Span<const Index> edge_half_edge() const { return edge_half_edge_; }
  // A half-edge that leaves each vertex; at a boundary vertex the one along the boundary, which
  // starts the fan.
  absl::Span<const Index> vertex_half_edge() const { return vertex_half_edge_; }

  // Meshes from Build only (arity() == 0):
  // first half-edge of each face, and at the end their number;
  absl::Span<const Index> face_begin() const { return face_begin_; }
  // face of each half-edge;
  absl::Span<const Index> face() const { return face_; }
  // half-edges that leave vertex v, counter-clockwise: fan()[fan_begin()[v] .. fan_begin()[v+1]).
  absl::Span<const Index> fan_begin() const { return fan_begin_; }
  absl::Span<const Index> fan() const { return fan_; }
  // Faces around v.
  std::size_t valence(std::size_t v) const { return fan_begin_[v + 1] - fan_begin_[v]; }

 private:
  friend class HalfEdgeMeshBuilder;
  friend class QuadSplitter;
  friend class TriangleSplitter;
  HalfEdgeMesh() = default;

  std::uint32_t arity_ = 0;
  Buffer<Index> vertex_;
  Buffer<Index> twin_;
  Buffer<Index> edge_;
  Buffer<Index> edge_half_edge_;
  Buffer<Index> vertex_half_edge_;
  Buffer<Index> face_begin_;
  Buffer<Index> face_;
  Buffer<Index> fan_begin_;
  Buffer<Index> fan_;
};

// Steps inside faces, for inner loops: pick the walk once, per mesh.
// Faces of any arity, meshes from Build.
class PolygonWalk {
 public:
  explicit PolygonWalk(const HalfEdgeMesh& mesh)
      : face_begin_(mesh.face_begin().data()), face_(mesh.face().data()) {}
  Index Face(Index h) const { return face_[h]; }
  Index FaceBegin(Index f) const { return face_begin_[f]; }
  Index FaceEnd(Index f) const { return face_begin_[f + 1]; }
  Index Next(Index h) const {
    const Index f = face_[h];
    return h + 1 == face_begin_[f + 1] ? face_begin_[f] : h + 1;
  }
  Index Prev(Index h) const {
    const Index f = face_[h];
    return h == face_begin_[f] ? face_begin_[f + 1] - 1 : h - 1;
  }

 private:
  const Index* face_begin_;
  const Index* face_;
};

// Meshes of quads only, refined or from Build: no memory is touched.
class QuadWalk {
 public:
  explicit QuadWalk(const HalfEdgeMesh& /*mesh*/) {}
  static Index Face(Index h) { return h / 4; }
  static Index FaceBegin(Index f) { return 4 * f; }
  static Index FaceEnd(Index f) { return 4 * f + 4; }
  static Index Next(Index h) { return (h & ~Index{3}) | ((h + 1) & 3); }
  static Index Prev(Index h) { return (h & ~Index{3}) | ((h + 3) & 3); }
};

// Meshes of triangles only, refined or from Build: no memory is touched.
class TriangleWalk {
 public:
  explicit TriangleWalk(const HalfEdgeMesh& /*mesh*/) {}
  static Index Face(Index h) { return h / 3; }
  static Index FaceBegin(Index f) { return 3 * f; }
  static Index FaceEnd(Index f) { return 3 * f + 3; }
  static Index Next(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static Index Prev(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }
};

// Calls f with the walk that fits the mesh.
template <class F>
auto WithWalk(const HalfEdgeMesh& mesh, F&& f) {
  if (mesh.arity() == 4) return f(QuadWalk(mesh));
  if (mesh.arity() == 3) return f(TriangleWalk(mesh));
  return f(PolygonWalk(mesh));
}

// Half-edges that leave h's vertex, next to h: counter-clockwise across Prev(h), and clockwise
// across h itself. kNoIndex past a boundary.
template <class Walk>
Index RotateCcw(const Walk& walk, absl::Span<const Index> twin, Index h) {
  return twin[walk.Prev(h)];
}
template <class Walk>
Index RotateCw(const Walk& walk, absl::Span<const Index> twin, Index h) {
  const Index t = twin[h];
  return t == kNoIndex ? kNoIndex : walk.Next(t);
}

// Calls visit(h) for the half-edges that leave a vertex, counter-clockwise from `start`, which is
// the vertex's own (see vertex_half_edge). Returns kNoIndex inside a mesh, and at a boundary the
// half-edge that enters the vertex along it, which no visited one is the twin of.
template <class Walk, class Visit>
Index VisitFan(const Walk& walk, absl::Span<const Index> twin, Index start, const Visit& visit) {
  Index h = start;
  while (true) {
    visit(h);
    const Index entering = walk.Prev(h);
    h = twin[entering];
    if (h == start) return kNoIndex;
    if (h == kNoIndex) return entering;
  }
}

}  // namespace limn
