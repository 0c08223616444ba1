// SPDX-License-Identifier: MIT
// The ring of a vertex of a level of a Catmull-Clark or Loop surface, read from the level's arrays.
#pragma once

#include <cstddef>

#include "absl/types/span.h"
#include "engine/base/vec3.h"
#include "engine/limit/ring_limit.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/scheme/sharpness.h"

namespace limn {

// A level and its points.
struct LevelPoints {
  LevelPoints(const SurfaceLevel& level, absl::Span<const Vec3> points)
      : mesh(level.mesh), sharpness(level.sharpness), in(points.data()) {}

  float SharpnessOf(Index h) const {
    return sharpness.creased() ? sharpness.edge[mesh.edge()[h]] : 0;
  }
  // entering: what VisitFan returned for v.
  template <class Walk>
  float CornerSharpness(const Walk& walk, std::size_t v, Index entering) const {
    if (sharpness.creased()) return sharpness.vertex[v];
    const bool corner = sharpness.boundary == BoundaryRule::kEdgeAndCorner &&
                        entering != kNoIndex && entering == walk.Prev(mesh.vertex_half_edge()[v]);
    return corner ? kSharpForever : 0;
  }

  const HalfEdgeMesh& mesh;
  const Sharpness& sharpness;
  const Vec3* in;
};

// Fills `ring` with what is around the vertex that `first` leaves, with its sharpness as it is.
// across(h): the point of a ring's face, h leaving the vertex in that face; for quads only. Edge 0
// is `first` inside a mesh, the boundary's at a boundary. Returns which face of the ring is the one
// of `first`.
template <RingKind kKind, class Walk, class Across>
std::size_t GatherRing(const LevelPoints& level, const Walk& walk, Index first,
                       const Across& across, VertexRing* ring) {
  ring->Clear();
  const HalfEdgeMesh& mesh = level.mesh;
  const Index v = mesh.vertex()[first];
  const Vec3 point = level.in[v];
  ring->point = point;
  const Index own = mesh.vertex_half_edge()[v];
  std::size_t place = 0;
  const Index start = mesh.twin()[own] == kNoIndex ? own : first;
  const Index entering = VisitFan(walk, mesh.twin(), start, [&](Index h) {
    if (h == first) place = ring->edge.size();
    ring->edge.push_back(level.in[mesh.vertex()[walk.Next(h)]] - point);
    ring->sharp.push_back(level.SharpnessOf(h));
    if constexpr (kKind == RingKind::kQuads) ring->face.push_back(across(h) - point);
  });
  if (entering != kNoIndex) {
    ring->closed = false;
    ring->edge.push_back(level.in[mesh.vertex()[entering]] - point);
    ring->sharp.push_back(kSharpForever);
    ring->sharp[0] = kSharpForever;
  }
  ring->corner = level.CornerSharpness(walk, v, entering);
  return place;
}

}  // namespace limn
