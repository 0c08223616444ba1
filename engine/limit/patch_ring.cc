// SPDX-License-Identifier: MIT
#include "engine/limit/patch_ring.h"

#include "engine/refine/doo_sabin_rule.h"

namespace limn {
namespace {

// The four images in a quad a, b, c, d, counter-clockwise from the lower left.
struct QuadCells {
  Vec3* a;
  Vec3* b;
  Vec3* c;
  Vec3* d;
};
void RefineQuad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const QuadCells& out) {
  *out.a = QuadImage(a, b, d, c);
  *out.b = QuadImage(b, a, c, d);
  *out.c = QuadImage(c, b, d, a);
  *out.d = QuadImage(d, a, c, b);
}

}  // namespace

BiquadraticNet QuarterNet(const RefinedGrid& grid, std::size_t row, std::size_t column) {
  BiquadraticNet net;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) net[j][i] = grid[row + j][column + i];
  }
  return net;
}

bool RegularNet(const HalfEdgeMesh& mesh, const Vec3* corners, Index h, BiquadraticNet* net) {
  const QuadWalk walk(mesh);
  const absl::Span<const Index> twin = mesh.twin();
  const Index next = walk.Next(h);
  const Index prev = walk.Prev(h);
  const Index ccw = twin[prev];
  if (ccw == kNoIndex || ccw == h) return false;
  const Index opposite = twin[walk.Prev(ccw)];
  if (opposite == kNoIndex || opposite == h) return false;
  const Index cw = twin[walk.Prev(opposite)];
  if (cw == kNoIndex || cw == h || twin[walk.Prev(cw)] != h) return false;
  *net = {{{corners[opposite], corners[cw], corners[twin[h]]},
           {corners[ccw], corners[h], corners[next]},
           {corners[walk.Next(ccw)], corners[prev], corners[walk.Next(next)]}}};
  return true;
}

BiquadraticNet PatchRing::Net(std::size_t i) const {
  return {{{Corner(i + 2), Corner(i + 3), left[i]},
           {Corner(i + 1), Corner(i), right[i]},
           {right[i + 1], left[i + 1], diagonal[i]}}};
}

RefinedGrid PatchRing::Refined(std::size_t i, absl::Span<const Vec3> center_images) const {
  const std::size_t sides = center.size();
  const Vec3& own = center[i];
  const Vec3& clockwise = Corner(i + sides - 1);
  const Vec3& counter_clockwise = Corner(i + 1);
  RefinedGrid grid = {};
  grid[0][1] = center_images[(i + sides - 1) % sides];
  grid[1][1] = center_images[i];
  grid[1][0] = center_images[(i + 1) % sides];
  if (sides == 4) grid[0][0] = center_images[(i + 2) % sides];
  RefineQuad(clockwise, left[i], right[i], own,
             {&grid[0][2], &grid[0][3], &grid[1][3], &grid[1][2]});
  RefineQuad(counter_clockwise, own, left[i + 1], right[i + 1],
             {&grid[2][0], &grid[2][1], &grid[3][1], &grid[3][0]});
  RefineQuad(own, right[i], diagonal[i], left[i + 1],
             {&grid[2][2], &grid[2][3], &grid[3][3], &grid[3][2]});
  return grid;
}

void GatherRing(const HalfEdgeMesh& mesh, const Vec3* corners, absl::Span<const Index> fan,
                PatchRing* ring) {
  const QuadWalk walk(mesh);
  const std::size_t sides = fan.size();
  ring->sectors = sides;
  ring->corner.assign(fan.begin(), fan.end());
  ring->center.resize(sides);
  ring->diagonal.resize(sides);
  ring->right.resize(sides + 1);
  ring->left.resize(sides + 1);
  for (std::size_t i = 0; i < sides; ++i) {
    const Index next = walk.Next(fan[i]);
    ring->center[i] = corners[fan[i]];
    ring->right[i] = corners[next];
    ring->diagonal[i] = corners[walk.Next(next)];
    ring->left[i + 1] = corners[walk.Prev(fan[i])];
  }
  ring->right[sides] = ring->right[0];
  ring->left[0] = ring->left[sides];
}

void GatherBoundaryRing(const HalfEdgeMesh& mesh, const BoundaryCurve& curve, const Vec3* corners,
                        Index i, BoundaryFace* face, PatchRing* ring) {
  GatherBoundaryFace(mesh, curve, corners, i, face);
  GatherRing(mesh, corners, face->corner, ring);
  ring->center.assign(face->point.begin(), face->point.end());
  // Beyond the half-edges along the boundary: G_b of the one that leaves, G_a of the one that
  // enters.
  ring->left[0] = BoundaryEdgeFace(mesh, curve, corners, i)[3];
  ring->right[ring->sectors] = BoundaryEdgeFace(mesh, curve, corners, curve.previous[i])[2];
}

RingRefiner::RingRefiner(PatchRing* ring) : ring_(*ring) { Refine(); }

void RingRefiner::Refine() {
  images_.resize(ring_.center.size());
  FaceImages(
      ring_.center.size(), [&](std::size_t i) { return ring_.center[i]; },
      [&](std::size_t i, const Vec3& image) { images_[i] = image; });
  grids_.resize(ring_.sectors);
  for (std::size_t i = 0; i < ring_.sectors; ++i) grids_[i] = ring_.Refined(i, images_);
}

void RingRefiner::Advance(double scale) {
  const std::size_t last = ring_.sectors;
  for (std::size_t i = 0; i < images_.size(); ++i) ring_.center[i] = scale * images_[i];
  for (std::size_t i = 0; i < last; ++i) {
    ring_.right[i] = scale * grids_[i][1][2];
    ring_.left[i + 1] = scale * grids_[i][2][1];
    ring_.diagonal[i] = scale * grids_[i][2][2];
  }
  ring_.left[0] = scale * grids_[0][0][2];
  ring_.right[last] = scale * grids_[last - 1][2][0];
  Refine();
}

}  // namespace limn
