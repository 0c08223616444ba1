// SPDX-License-Identifier: MIT
// The control points that shape the patches of a refined Doo-Sabin mesh M^k, k >= 2: a 3 x 3 net
// where the four faces around a control point are quads, and a ring of patches around a face with
// any number of sides or at a boundary. Sources: Doo and Sabin 1978; Stam 1998 (the idea that an
// irregular patch is an endless sequence of regular ones).
//
//   left[i+1] o---o diagonal[i]        Sector i of a ring is the patch of W_i = center[i], a corner
//     W_i+1   |   |                    of the face in the middle: the square (u, v) in [0, 1]^2
//         o---o---o right[i]           from the face's centroid (0, 0) along the half-edge that
//          \  |W_i|                    leaves the face's vertex. Gap i is the type-E face of that
//    center \ o---o left[i]            half-edge: right[i], W_i, W_(i-1), left[i].
//             W_i-1
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "absl/types/span.h"
#include "engine/base/vec3.h"
#include "engine/limit/biquadratic.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/refine/boundary_curve.h"

namespace limn {

// The control points of M^(k+1) in the four faces around a control point of M^k: grid[row][column].
// The 3 x 3 nets inside it are those of the quarters of the patch. grid[0][0] is missing where the
// face in the middle of the ring is not a quad.
using RefinedGrid = std::array<std::array<Vec3, 4>, 4>;

// The net of the quarter of a patch whose corner (0, 0) is at (u, v) = (column, row) / 2.
BiquadraticNet QuarterNet(const RefinedGrid& grid, std::size_t row, std::size_t column);

// The net of the patch of corner h of T^(k-1), all quads. False, and nothing is written, where one
// of its faces is not a quad or is completed by ghosts: then the patch is part of a ring. Cost:
// constant. Thread-safe.
bool RegularNet(const HalfEdgeMesh& mesh, const Vec3* corners, Index h, BiquadraticNet* net);

// A ring of patches. Plain data; points are relative to the boundary's origin.
struct PatchRing {
  // Patches: as many as the face has sides, or, at a boundary vertex, as there are quads.
  std::size_t sectors = 0;
  // Corners of the face in the middle, ghosts last.
  std::vector<Vec3> center;
  // `sectors` of diagonal, sectors + 1 of right and left, the last the same as the first unless
  // there is a boundary.
  std::vector<Vec3> right;
  std::vector<Vec3> left;
  std::vector<Vec3> diagonal;
  // Half-edges of T^(k-1) whose points W_i are.
  std::vector<Index> corner;

  bool closed() const { return sectors == center.size(); }
  bool regular() const { return center.size() == 4; }
  // W_i, also for i = -1 (as sides - 1) and i = sectors.
  const Vec3& Corner(std::size_t i) const { return center[i % center.size()]; }
  // The patch's net; regular rings only.
  BiquadraticNet Net(std::size_t i) const;
  // The patch's refined points.
  RefinedGrid Refined(std::size_t i, absl::Span<const Vec3> center_images) const;
};

// Fills *ring with that of the interior vertex of T^(k-1) whose fan, counter-clockwise, is
// corner(0) .. corner(sides - 1). mesh: T^(k-1), all quads. Cost: linear in the sides.
void GatherRing(const HalfEdgeMesh& mesh, const Vec3* corners, absl::Span<const Index> fan,
                PatchRing* ring);

// The same for the boundary vertex that boundary half-edge i leaves. *face is scratch.
void GatherBoundaryRing(const HalfEdgeMesh& mesh, const BoundaryCurve& curve, const Vec3* corners,
                        Index i, BoundaryFace* face, PatchRing* ring);

// Refines rings step by step.
class RingRefiner {
 public:
  // *ring must outlive this and is changed by Advance.
  explicit RingRefiner(PatchRing* ring);

  // Refined points of sector i.
  const RefinedGrid& grid(std::size_t i) const { return grids_[i]; }
  // The ring becomes that of M^(k+1), half as large, times `scale`.
  void Advance(double scale = 1);

 private:
  void Refine();

  PatchRing& ring_;
  std::vector<Vec3> images_;
  std::vector<RefinedGrid> grids_;
};

}  // namespace limn
