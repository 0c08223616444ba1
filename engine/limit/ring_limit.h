// SPDX-License-Identifier: MIT
// Limit point, tangents and normal of one vertex from the ring of points around it, by the masks of
// engine/limit/limit_masks.h and the rule of the vertex.
#pragma once

#include <cstddef>
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
  // Sharpness of each edge; boundary edges have kSharpForever.
  std::vector<float> sharp;
  bool closed = true;
  // Sharpness of the vertex itself.
  float corner = 0;

  void Clear() {
    edge.clear();
    face.clear();
    sharp.clear();
    closed = true;
    corner = 0;
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

// The ring of the next level, with what is sharp worn by one refinement. centroids: `face` holds
// the centroids of faces of any arity, as around the vertices of T^0, instead of the vertices
// across quads.
void RefineRing(RingKind kind, bool centroids, VertexRing* ring);

// Refines the ring until nothing of it wears off any more.
void SettleRing(RingKind kind, VertexRing* ring);

// How the surface in one face of the ring meets the vertex.
struct CornerFrame {
  Vec3 point = {0, 0, 0};
  // Tangents along the two edges of the face, counter-clockwise; see RingCorner.
  Vec3 first = {0, 0, 0};
  Vec3 second = {0, 0, 0};
  // Of the surface on this side of what is sharp.
  Vec3 normal = {0, 0, 0};
};

// The ring counts as it is: as if what is sharp stayed so.
[[nodiscard]] Vec3 RingPoint(RingKind kind, const VertexRing& ring);
// The same point to the bit, with the rest.
[[nodiscard]] VertexFrame RingFrame(RingKind kind, const VertexRing& ring);
// The same point, from the face between the edges `face` and `face + 1`. With u and v as in
// engine/limit/vertex_limit.h, in a sector of f faces (n around a smooth vertex) the tangent of its
// edge i is
//   smooth, dart: cos(2 pi i / n) u + sin(2 pi i / n) v;
//   boundary, crease: cos(pi i / f) u + sin(pi i / f) v, with one face u and -u;
//   corner: the derivatives of the curves at both ends, between them sin(pi i / f) v, v across;
//     at two triangles the sum of both derivatives.
// These are derivatives by parameters in which the ring's edges have length 1, where there are
// such: at regular vertices, and along sharp edges. Elsewhere they grow beyond all bounds or vanish
// toward the vertex (like (2 lambda)^k over k refinements), and these are their directions, with
// the sizes that continue those at regular vertices.
[[nodiscard]] CornerFrame RingCorner(RingKind kind, const VertexRing& ring, std::size_t face);

}  // namespace limn
