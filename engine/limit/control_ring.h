// SPDX-License-Identifier: MIT
// A control point of the first refined mesh M^1 with all that shapes the patch around it: its four
// faces. Ghosts stand in for what lies outside a boundary (engine/refine/boundary_curve.h), so that
// nothing after this knows of boundaries.
//
//     above_left o-----o above    o    The patch of W is the square (u, v) in [0, 1]^2 between the
//                |  E  |    far        centroids of its faces: near (0, 0), at first the type-V
//          next  o-----W-----o right   face, far (1, 1), the type-F face, and the type-E faces of
//       near           |  E  |         the edges that leave and enter the corner. `near` and `far`
//           o  previous o----o         may have any number of sides.
//                       below_right
#pragma once

#include <array>
#include <cstddef>

#include "engine/base/vec3.h"
#include "engine/limit/large_faces.h"
#include "engine/refine/boundary_curve.h"
#include "engine/refine/doo_sabin_surface.h"
#include "engine/refine/harmonics.h"

namespace limn {

// A face as one of its corners sees it.
struct FaceAtCorner {
  // Which of the corners: the one before (clockwise), the own one, the next (counter-clockwise).
  enum Which : std::size_t { kPrevious, kOwn, kNext };

  std::size_t sides = 0;
  Harmonics harmonics = {};
  std::array<Vec3, 3> point = {};
  // First harmonic components of these points: what refinement multiplies by `subdominant`.
  std::array<Vec3, 3> first = {};
  // The corner opposite the own one; quads only.
  Vec3 opposite = {};

  bool regular() const { return sides == 4; }
  const Vec3& centre() const { return harmonics.mean; }
  // Eigenvalue of the first harmonic. With two sides it has one dimension only, and the rule of
  // [ZC Eq. 1] is 3/4.
  double subdominant() const { return sides == 2 ? 0.75 : 0.5; }
  // What refinement multiplies by 1/4.
  Vec3 Rest(Which which) const { return point[which] - centre() - first[which]; }
  // Image of the point by refinement [ZC Eq. 1].
  Vec3 Image(Which which) const {
    return centre() + subdominant() * first[which] + 0.25 * Rest(which);
  }
};

struct ControlRing {
  FaceAtCorner near;
  FaceAtCorner far;
  Vec3 below_right = {};
  Vec3 above_left = {};

  const Vec3& own() const { return near.point[FaceAtCorner::kOwn]; }
  const Vec3& previous() const { return near.point[FaceAtCorner::kPrevious]; }
  const Vec3& next() const { return near.point[FaceAtCorner::kNext]; }
  const Vec3& right() const { return far.point[FaceAtCorner::kNext]; }
  const Vec3& above() const { return far.point[FaceAtCorner::kPrevious]; }
};

// The same ring turned by half a turn: (u, v) becomes (1 - u, 1 - v).
ControlRing HalfTurned(const ControlRing& ring);

// Gathers rings. Each thread needs one of its own; surface and large_faces must outlive it.
class RingGatherer {
 public:
  RingGatherer(const DooSabinSurface& surface, const LargeFaces& large_faces)
      : surface_(surface), large_faces_(large_faces), walk_(surface.mesh) {}

  // The ring of the point of half-edge h of T^0, relative to the surface's origin. Cost: linear in
  // the sides of small faces, logarithmic in the number of large ones.
  ControlRing Gather(Index h);

 private:
  FaceAtCorner VertexFace(Index h);
  FaceAtCorner BoundaryVertexFace(Index h);
  FaceAtCorner FaceFace(Index h) const;

  const DooSabinSurface& surface_;
  const LargeFaces& large_faces_;
  PolygonWalk walk_;
  BoundaryFace boundary_face_;
};

}  // namespace limn
