// SPDX-License-Identifier: MIT
// Which control points of T^2 a constraint on the surface moves, and how much.
// Source: Chen et al., "Interpolating meshes of arbitrary topology by Catmull-Clark surfaces",
// sections 5 and 6 (local blending), with rings of control points for regions.
//
// Ring 0 are the vertices of the face of T^2 that the place is in, or the vertex that it is at;
// ring r those that share a face with ring r - 1. What the surface does at the place depends on
// rings 0 and 1 alone: its support. Rings 0 to p follow the constraint fully, from ring R on
// nothing moves, between them the share falls smoothly.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/types/span.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// A place of T^2: ring 0. Never empty.
using BlendPlace = std::vector<Index>;

// Places by the vertices of their ring 0: those of constraints, with numbers from 0 on, and after
// them the vertices of T^0 that are to stay, with the vertex added to constraint_count().
class BlendPlaces {
 public:
  // mesh: T^2. stays: of the vertices of T^0, 1 for those whose points are to stay where they are.
  // Both must outlive this.
  BlendPlaces(const HalfEdgeMesh& mesh, absl::Span<const std::uint8_t> stays)
      : mesh_(mesh), stays_(stays) {}

  // The next constraint's. One at a vertex takes the place of the vertex that stays.
  void Add(BlendPlace place);

  const HalfEdgeMesh& mesh() const { return mesh_; }
  std::size_t constraint_count() const { return places_.size(); }
  BlendPlace At(std::size_t i) const {
    return i < places_.size() ? places_[i] : BlendPlace{static_cast<Index>(i - places_.size())};
  }

  // Calls visit(i) for the places with this vertex in ring 0, until it returns false.
  template <class Visit>
  void VisitAt(Index v, const Visit& visit) const {
    const auto found = by_vertex_.find(v);
    if (found != by_vertex_.end()) {
      for (const std::size_t i : found->second) {
        if (!visit(i)) return;
      }
    }
    if (v < stays_.size() && stays_[v] != 0 && !taken_.contains(v)) visit(places_.size() + v);
  }

 private:
  const HalfEdgeMesh& mesh_;
  const absl::Span<const std::uint8_t> stays_;
  std::vector<BlendPlace> places_;
  absl::flat_hash_map<Index, std::vector<std::size_t>> by_vertex_;
  absl::flat_hash_set<Index> taken_;
};

struct BlendRegion {
  // Control points that move, each once, in the order in which they are found.
  std::vector<Index> vertices;
  // In (0, 1], of each.
  std::vector<double> weights;
  // Other places whose support has some of them; ascending. More than kMostTouched: not all.
  std::vector<std::size_t> touched;
};

inline constexpr std::size_t kMostTouched = 256;

// The largest region, R from 3 to 6 and p = R / 2, that touches no other place; R = 3 when all do.
// Cost: linear in the corners around the region. Thread-safe.
[[nodiscard]] BlendRegion ChooseRegion(const BlendPlaces& places, std::size_t i);

// The region of the control points that shape these faces of T^2 and no others; p is half of the
// rings until the nearest one that shapes others too, at least 1. Empty when it does not contain
// the support of place i: the place is less than three rings of faces inside. Cost: linear in the
// corners around the faces. Thread-safe.
[[nodiscard]] BlendRegion GivenRegion(const BlendPlaces& places, std::size_t i,
                                      absl::Span<const Index> faces);

// The vertices of the place's rings 0 and 1, ring by ring.
[[nodiscard]] std::vector<Index> Support(const HalfEdgeMesh& mesh, const BlendPlace& place);

// Calls visit(w) for the vertices w that share a face with v, some of them more than once.
template <class Visit>
void VisitRing(const HalfEdgeMesh& mesh, Index v, const Visit& visit) {
  WithWalk(mesh, [&](const auto& walk) {
    VisitFan(walk, mesh.twin(), mesh.vertex_half_edge()[v], [&](Index h) {
      for (Index g = walk.Next(h); g != h; g = walk.Next(g)) visit(mesh.vertex()[g]);
    });
  });
}

}  // namespace limn
