// SPDX-License-Identifier: MIT
// Where the surface is one polynomial: rings of vertices as those of a regular mesh.
#pragma once

#include <array>
#include <cstddef>

#include "engine/base/vec3.h"
#include "engine/limit/ring_limit.h"

namespace limn {

// The points around a vertex of four quads or six triangles, as differences to it, from the first
// edge of a face on, counter-clockwise. Quads: edge i, and across the face between i and i + 1 the
// point diagonal[i]. Triangles: edge only.
struct RegularRing {
  std::array<Vec3, 6> edge;
  std::array<Vec3, 4> diagonal;
};

// Whether the surface in a face of the ring is, as far as this corner of the face goes, that of a
// regular mesh without anything sharp, whose ring is then in `regular`:
//   - a smooth vertex of four quads or six triangles;
//   - a crease or boundary for ever, with two quads or three triangles on the face's side;
//   - a corner for ever, with one face.
// Beyond what is sharp, mirror points take the place of what is there: a row P_(-1) = 2 P_0 - P_1,
// for triangles A + B - C beyond the side A B. Cubic curves and the faces' own points are what they
// would be without, by every refinement.
[[nodiscard]] bool FindRegularRing(RingKind kind, const VertexRing& ring, std::size_t face,
                                   RegularRing* regular);

}  // namespace limn
