// SPDX-License-Identifier: MIT
#include "engine/limit/primal_patch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/limit/bicubic.h"
#include "engine/limit/box_spline.h"
#include "engine/scheme/sharpness.h"

namespace limn {
namespace {

Vec3 TimesPowerOfTwo(const Vec3& a, int exponent) {
  return {std::ldexp(a.x, exponent), std::ldexp(a.y, exponent), std::ldexp(a.z, exponent)};
}

std::size_t Before(std::size_t i, std::size_t n) { return i == 0 ? n - 1 : i - 1; }

// Of the places of a ring, the one after i others.
std::size_t After(std::size_t face, std::size_t i, const VertexRing& ring) {
  return (face + i) % ring.edge.size();
}

}  // namespace

PatchSample PrimalPatch::Evaluate(double u, double v) {
  Start(u, v);
  while (!FindSpline()) {
    const std::size_t at = place_.CornerAt();
    // A regular one is in a polynomial after another refinement, as exact as the patch is deep.
    if (at < sides() && !IsRegular(at)) return CornerSample(at);
    const std::size_t near = place_.CornerNear();
    Refine();
    place_.EnterChild();
    if (near < sides()) {
      EnterChild(near);
    } else {
      EnterMiddle();
    }
  }
  return SplineSample();
}

void PrimalPatch::Start(double u, double v) {
  place_ = {.kind = kind_, .u = u, .v = v};
  depth_ = 0;
  work_ = 0;
  magnitude_ = 0;
  origin_ = corners_[0].ring.point;
  for (std::size_t i = 0; i < sides(); ++i) {
    magnitude_ = std::max(magnitude_, MaxAbs(corners_[i].ring.point));
    corners_[i].ring.point -= origin_;
  }
  first_size_ = LocalSize();
}

double PrimalPatch::LocalSize() const {
  double size = 0;
  for (std::size_t i = 0; i < sides(); ++i) {
    size = std::max(size, MaxAbs(corners_[i].ring.edge[corners_[i].face]));
  }
  return size;
}

bool PrimalPatch::IsRegular(std::size_t corner) {
  const auto& [ring, face] = corners_[corner];
  return FindRegularRing(kind_, ring, face, &regular_[corner]);
}

bool PrimalPatch::FindSpline() {
  for (std::size_t i = 0; i < sides(); ++i) {
    if (!IsRegular(i)) return false;
  }
  return true;
}

void PrimalPatch::Refine() {
  for (std::size_t i = 0; i < sides(); ++i) {
    RefineRing(kind_, false, &corners_[i].ring);
    work_ += corners_[i].ring.edge.size();
  }
}

Vec3 PrimalPatch::SidePoint(std::size_t i) const {
  const std::size_t next = i + 1 == sides() ? 0 : i + 1;
  const auto& [ring, face] = corners_[next == kept_ ? next : i];
  return ring.point + ring.edge[next == kept_ ? After(face, 1, ring) : face];
}
Vec3 PrimalPatch::Centre() const {
  const auto& [ring, face] = corners_[kept_];
  return ring.point + ring.face[face];
}

void PrimalPatch::SetVertex(std::size_t corner, std::size_t place) {
  std::swap(children_[place], corners_[corner]);
}

// The ring of the point of a side, between corner `side` and the next one, `face` counted as below.
// All that the corner which is kept knows comes from its own ring: it shrinks by its own
// eigenvalues, and what other rings know of it would not, by the rounding errors between them.
void PrimalPatch::SetEdge(std::size_t side, std::size_t face, std::size_t place) {
  const std::size_t n = sides();
  const std::size_t next = side + 1 == n ? 0 : side + 1;
  const VertexRing& a = corners_[side].ring;
  const VertexRing& b = corners_[next].ring;
  const std::size_t at_a = corners_[side].face;
  const std::size_t at_b = corners_[next].face;
  const bool quads = kind_ == RingKind::kQuads;
  const bool by_b = next == kept_;
  PatchCorner& child = children_[place];
  VertexRing& ring = child.ring;
  ring.Clear();
  const Vec3 point = SidePoint(side);
  ring.point = point;
  const Vec3 to_a = by_b ? a.point - point : -a.edge[at_a];
  const Vec3 to_b = by_b ? -b.edge[After(at_b, 1, b)] : b.point - point;
  // Side points of this face, at b and at a.
  const Vec3 at_b_side = b.edge[at_b] + to_b;
  const Vec3 at_a_side = a.edge[After(at_a, 1, a)] + to_a;
  Vec3 middle = {0, 0, 0};
  if (quads) middle = by_b ? b.face[at_b] + to_b : a.face[at_a] + to_a;
  const float sharp = a.sharp[at_a];
  const bool open = !a.closed && at_a == 0;
  if (!open) {
    // Beyond the side.
    const Vec3 beyond_a = a.edge[Before(at_a, a.edge.size())] + to_a;
    const Vec3 beyond_b = b.edge[After(at_b, 2, b)] + to_b;
    if (quads) {
      const Vec3 other = by_b ? b.face[(at_b + 1) % b.face.size()] + to_b
                              : a.face[Before(at_a, a.face.size())] + to_a;
      ring.edge = {to_a, other, to_b, middle};
      ring.face = {beyond_a, beyond_b, at_b_side, at_a_side};
      ring.sharp = {sharp, 0, sharp, 0};
    } else {
      ring.edge = {to_a, beyond_a, beyond_b, to_b, at_b_side, at_a_side};
      ring.sharp = {sharp, 0, 0, sharp, 0, 0};
    }
    child.face = face;
    return;
  }
  ring.closed = false;
  if (quads) {
    ring.edge = {to_b, middle, to_a};
    ring.face = {at_b_side, at_a_side};
    ring.sharp = {sharp, 0, sharp};
    child.face = face - 2;
  } else {
    ring.edge = {to_b, at_b_side, at_a_side, to_a};
    ring.sharp = {sharp, 0, 0, sharp};
    child.face = face - 3;
  }
}

void PrimalPatch::SetCentre(std::size_t face, std::size_t place) {
  PatchCorner& child = children_[place];
  VertexRing& ring = child.ring;
  ring.Clear();
  ring.point = Centre();
  ring.edge.resize(4);
  ring.face.resize(4);
  ring.sharp.assign(4, 0);
  for (std::size_t i = 0; i < 4; ++i) {
    ring.edge[i] = SidePoint(i) - ring.point;
    ring.face[i] = corners_[(i + 1) & 3].ring.point - ring.point;
  }
  child.face = face;
}

// Faces of the ring of a side's point, counter-clockwise from the one beyond the side that begins
// at the side's start: quads 0, 1 beyond, 2 at the side's end, 3 at its start; triangles 0, 1, 2
// beyond, 3 at the end, 4 the middle one, 5 at the start.
void PrimalPatch::EnterChild(std::size_t corner) {
  kept_ = corner;
  const std::size_t before = Before(corner, sides());
  if (kind_ == RingKind::kQuads) {
    SetEdge(corner, 3, 1);
    SetCentre(before, 2);
    SetEdge(before, 2, 3);
  } else {
    SetEdge(corner, 5, 1);
    SetEdge(before, 3, 2);
  }
  SetVertex(corner, 0);
  Magnify();
}

void PrimalPatch::EnterMiddle() {
  kept_ = sides();
  for (std::size_t i = 0; i < 3; ++i) SetEdge(i, 4, i);
  Magnify();
}

void PrimalPatch::Magnify() {
  const Vec3 moved = children_[0].ring.point;
  origin_ += TimesPowerOfTwo(moved, -depth_);
  ++depth_;
  for (std::size_t i = 0; i < sides(); ++i) {
    VertexRing& ring = children_[i].ring;
    ring.point = 2 * (ring.point - moved);
    for (Vec3& p : ring.edge) p *= 2;
    for (Vec3& p : ring.face) p *= 2;
  }
  std::swap(corners_, children_);
}

Vec3 PrimalPatch::ToModel(const Vec3& local) const {
  return origin_ + TimesPowerOfTwo(local, -depth_);
}

PatchSample PrimalPatch::SplineSample() const {
  SplineJet jet;
  if (kind_ == RingKind::kQuads) {
    BicubicNet net;
    // Row and column of the points that corner i adds, and the steps along its first two edges.
    constexpr int kRow[4] = {1, 1, 2, 2};
    constexpr int kColumn[4] = {1, 2, 2, 1};
    constexpr int kStep[5] = {1, 0, -1, 0, 1};
    const auto at = [&net](int row, int column) -> Vec3& {
      return net[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    };
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec3& point = corners_[i].ring.point;
      // Along edge 0 of the ring, and along edge 1.
      const int x = kStep[i];
      const int y = -kStep[i + 1];
      at(kRow[i], kColumn[i]) = point;
      at(kRow[i] - y, kColumn[i] - x) = point + regular_[i].edge[2];
      at(kRow[i] - x, kColumn[i] + y) = point + regular_[i].edge[3];
      at(kRow[i] - y - x, kColumn[i] - x + y) = point + regular_[i].diagonal[2];
    }
    jet = EvaluateBicubic(net, place_.u, place_.v);
  } else {
    BoxSplineNet net;
    for (std::size_t i = 0; i < 3; ++i) {
      net.corner[i] = corners_[i].ring.point;
      for (std::size_t j = 0; j < 6; ++j) {
        net.around[i][j] = net.corner[i] + regular_[i].edge[j];
      }
    }
    jet = EvaluateBoxSpline(net, place_.u, place_.v);
  }
  const Vec3 du = place_.turn.U(jet.du, jet.dv);
  const Vec3 dv = place_.turn.V(jet.du, jet.dv);
  // Rounding errors of the coordinates have grown like the patch itself.
  const double growth = first_size_ > 0 ? LocalSize() / first_size_ : 1;
  return {ToModel(jet.point), du, dv, UnitCross(du, dv, magnitude_ * growth)};
}

PatchSample PrimalPatch::CornerSample(std::size_t corner) {
  // In the model's scale, since what is noise depends on its place there.
  VertexRing& ring = corners_[corner].ring;
  ring.point = ToModel(ring.point);
  float most = 0;
  const auto note = [&](float sharpness) {
    if (sharpness < kSharpForever) most = std::max(most, sharpness);
  };
  note(ring.corner);
  for (const float sharpness : ring.sharp) note(sharpness);
  for (Vec3& p : ring.edge) p = TimesPowerOfTwo(p, -depth_);
  for (Vec3& p : ring.face) p = TimesPowerOfTwo(p, -depth_);
  SettleRing(kind_, &ring);
  const CornerFrame frame = RingCorner(kind_, ring, corners_[corner].face);
  const int depth = depth_ + static_cast<int>(std::ceil(most));
  const Vec3 first = TimesPowerOfTwo(frame.first, depth);
  const Vec3 second = TimesPowerOfTwo(frame.second, depth);
  PatchTurn turn = place_.turn;
  turn.Compose(place_.ToCorner(corner));
  return {frame.point, turn.U(first, second), turn.V(first, second), frame.normal};
}

}  // namespace limn
