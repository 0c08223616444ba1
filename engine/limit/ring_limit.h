// SPDX-License-Identifier: MIT
// Limit point, tangents and normal of one vertex from the ring of points around it, by the masks of
// engine/limit/limit_masks.h and the rule of the vertex.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/limit/limit_masks.h"

namespace limn {

// A ring: n edges counter-clockwise, and the quads or triangles between them. Used again for one
// vertex after the other, so that no memory is allocated.
struct VertexRing {
  Vec3 point = {0, 0, 0};
  // Ends of edges and, for quads, the vertices across, as differences to the point. Inside a mesh
  // as many of one as of the other; at a boundary one edge more.
  std::vector<Vec3> edge;
  std::vector<Vec3> face;
  // Whether each edge is sharp; boundary edges are.
  std::vector<std::uint8_t> sharp;
  bool closed = true;
  // Whether the vertex itself is sharp.
  bool corner = false;

  void Clear() {
    edge.clear();
    face.clear();
    sharp.clear();
    closed = true;
    corner = false;
  }
};

// Two tangents of the limit surface; see engine/limit/vertex_limit.h.
struct Tangents {
  Vec3 u = {0, 0, 0};
  Vec3 v = {0, 0, 0};
};

struct VertexFrame {
  Vec3 point = {0, 0, 0};
  Tangents tangents;
  Vec3 normal = {0, 0, 0};
};

[[nodiscard]] Vec3 RingPoint(RingKind kind, const VertexRing& ring);
// The same point to the bit, with the rest.
[[nodiscard]] VertexFrame RingFrame(RingKind kind, const VertexRing& ring);

}  // namespace limn
