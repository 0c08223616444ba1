// SPDX-License-Identifier: MIT
// The parts of Repair: the state that they hand on, and one function for each step. Internal to
// engine/mesh/repair*.cc; what the steps do is said in repair.h.
//
// A side is named by its corner: side c runs from corner c to Next(c). Two sides that are mates
// are glued: they become one edge. What is not glued becomes a boundary.
#pragma once

#include <algorithm>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/disjoint_sets.h"
#include "engine/mesh/polygon_mesh.h"
#include "engine/mesh/repair.h"

namespace limn::repair {

enum class FaceState : std::uint8_t {
  kLive,
  // Degenerate, and not to be repaired: comes out as it went in.
  kAside,
  kRemoved,
};

// Faces with the vertex numbers of the input, and how they hang together.
struct Patchwork {
  // As in PolygonMesh.
  Buffer<Index> face_begin;
  Buffer<Index> corner_vertex;
  // Per face.
  Buffer<Index> original_face;
  Buffer<FaceState> state;
  // Whether the face is turned round, 0 or 1, and its component, numbered by first faces.
  Buffer<std::uint8_t> turned;
  Buffer<Index> component;
  // Per corner: its face; the side that its side is glued to, or kNoIndex.
  Buffer<Index> corner_face;
  Buffer<Index> mate;
  // Faces of each component.
  Buffer<Index> component_size;

  std::size_t face_count() const { return original_face.size(); }
  std::size_t corner_count() const { return corner_vertex.size(); }
  bool live(std::size_t face) const { return state[face] == FaceState::kLive; }
  absl::Span<const Index> face(std::size_t f) const {
    return absl::MakeConstSpan(corner_vertex)
        .subspan(face_begin[f], face_begin[f + 1] - face_begin[f]);
  }

  Index Next(Index corner) const {
    const Index f = corner_face[corner];
    return corner + 1 == face_begin[f + 1] ? face_begin[f] : corner + 1;
  }
  Index Prev(Index corner) const {
    const Index f = corner_face[corner];
    return corner == face_begin[f] ? face_begin[f + 1] - 1 : corner - 1;
  }
  // The ends of a side, as vertices.
  Index Low(Index side) const { return std::min(corner_vertex[side], corner_vertex[Next(side)]); }
  Index High(Index side) const { return std::max(corner_vertex[side], corner_vertex[Next(side)]); }
  // The corner at one end of a side.
  Index CornerAt(Index side, Index vertex) const {
    return corner_vertex[side] == vertex ? side : Next(side);
  }
  // Whether the turned face walks the side from the low to the high end.
  bool Ascends(Index side) const {
    return (corner_vertex[side] < corner_vertex[Next(side)]) != (turned[corner_face[side]] != 0);
  }
  void Glue(Index a, Index b) {
    mate[a] = b;
    mate[b] = a;
  }
  void Unglue(Index side) {
    if (mate[side] == kNoIndex) return;
    mate[mate[side]] = kNoIndex;
    mate[side] = kNoIndex;
  }
};

// The sides of live faces, edge by edge: in the bucket of their low end, sorted by high end and
// then by number.
class EdgeTable {
 public:
  struct Entry {
    Index high;
    Index side;
  };

  // Cost: sorts the buckets, in parallel.
  [[nodiscard]] absl::Status Fill(const Context& context, std::size_t vertices,
                                  const Patchwork& patchwork);

  std::size_t vertex_count() const { return begin_.empty() ? 0 : begin_.size() - 1; }

  // Calls visit(entries) for each edge of which v is the low end, in order.
  template <class Visit>
  void ForEachEdge(std::size_t v, const Visit& visit) const {
    const Entry* const end = entry_.data() + begin_[v + 1];
    for (const Entry* first = entry_.data() + begin_[v]; first != end;) {
      const Entry* last = first + 1;
      while (last != end && last->high == first->high) ++last;
      visit(absl::MakeConstSpan(first, static_cast<std::size_t>(last - first)));
      first = last;
    }
  }

 private:
  Buffer<Index> begin_;
  Buffer<Entry> entry_;
};

// Edges that need a closer look, each with its sides.
struct EdgeList {
  Buffer<Index> begin = {0};
  Buffer<Index> side;

  std::size_t size() const { return begin.size() - 1; }
  absl::Span<const Index> sides(std::size_t edge) const {
    return absl::MakeConstSpan(side).subspan(begin[edge], begin[edge + 1] - begin[edge]);
  }
  // After the sides were appended.
  void EndEdge() { begin.push_back(static_cast<Index>(side.size())); }
};

// Step 1: fills everything per face and per corner but mates.
[[nodiscard]] absl::Status CleanFaces(const Context& context, const PolygonMesh& mesh, bool mend,
                                      Patchwork* patchwork, RepairReport* report);

// Step 2; folds: whether they are removed too.
[[nodiscard]] absl::Status RemoveRepeatedFaces(const Context& context, const EdgeTable& edges,
                                               bool folds, Patchwork* patchwork,
                                               RepairReport* report);

// Of step 2 the second part. folded: per face, whether it stands for as many faces of either way
// round.
[[nodiscard]] absl::Status RemoveFolds(const Context& context, const EdgeTable& edges,
                                       const Buffer<std::uint8_t>& folded, Patchwork* patchwork,
                                       RepairReport* report);

// Glues the sides of every edge of two live faces, and lists the edges of more.
[[nodiscard]] absl::Status GlueEdges(const Context& context, const EdgeTable& edges,
                                     Patchwork* patchwork, EdgeList* crowded);

// Step 3: finds the components and, with `turn`, turns faces and lists the edges it had to cut.
[[nodiscard]] absl::Status OrientFaces(const Context& context, bool turn, Patchwork* patchwork,
                                       EdgeList* cut, RepairReport* report);

// Step 4: glues sides of the crowded edges.
[[nodiscard]] absl::Status PairCrowdedEdges(const Context& context, const EdgeList& crowded,
                                            Patchwork* patchwork);

// Merges the corners at both ends of all glued sides. A corner has two sides, each glued to at most
// one other, so the faces of a class of corners form one fan or one ring: an umbrella.
[[nodiscard]] absl::Status JoinCorners(const Context& context, const Patchwork& patchwork,
                                       DisjointSets* corners);

// Step 5, the second part: unglues what would share both ends with another edge. Looks at the given
// edges only; no others can.
[[nodiscard]] absl::Status SplitOffFaces(const Context& context,
                                         absl::Span<const EdgeList* const> edges,
                                         Patchwork* patchwork, RepairReport* report);

// Where each corner's vertex is in the repaired mesh, and where that comes from.
struct VertexNumbers {
  Buffer<Index> corner_vertex;
  Buffer<Index> original_vertex;
  std::size_t kept = 0;
};

// Step 5, the first part, with options.non_manifold, and step 6. Mates are gone afterwards.
[[nodiscard]] absl::StatusOr<VertexNumbers> NumberVertices(const Context& context,
                                                           std::size_t vertices,
                                                           const RepairOptions& options,
                                                           Patchwork* patchwork,
                                                           RepairReport* report);

}  // namespace limn::repair
