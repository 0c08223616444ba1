// SPDX-License-Identifier: MIT
// A parameter of a quad or triangle on its way into the children that refinement makes of the
// patch, and what that does to derivatives.
#pragma once

#include <algorithm>
#include <cstddef>

#include "engine/base/vec3.h"
#include "engine/limit/limit_masks.h"

namespace limn {

// Derivatives by the given u and v from those by other ones, which are turned and not scaled.
struct PatchTurn {
  double uu = 1;
  double uv = 0;
  double vu = 0;
  double vv = 1;
  // The present ones become those of `next`, in which u and v of these are what it says.
  void Compose(const PatchTurn& next) {
    *this = {uu * next.uu + uv * next.vu, uu * next.uv + uv * next.vv, vu * next.uu + vv * next.vu,
             vu * next.uv + vv * next.vv};
  }
  Vec3 U(const Vec3& du, const Vec3& dv) const { return uu * du + uv * dv; }
  Vec3 V(const Vec3& du, const Vec3& dv) const { return vu * du + vv * dv; }
};

// From corner 0 of the patch, u along the side that leaves it and v along the side that enters it.
// Quads: both in [0, 1]. Triangles: both and their sum.
struct PatchPlace {
  RingKind kind = RingKind::kQuads;
  double u = 0;
  double v = 0;
  // From the patch that it all began with to the present one.
  PatchTurn turn = {};

  std::size_t sides() const { return kind == RingKind::kQuads ? 4 : 3; }

  // The corner that (u, v) is at, or sides().
  std::size_t CornerAt() const {
    if (v == 0 && u == 0) return 0;
    if (v == 0 && u == 1) return 1;
    if (kind == RingKind::kTriangles) return u == 0 && v == 1 ? 2 : 3;
    if (v == 1 && u == 1) return 2;
    return u == 0 && v == 1 ? 3 : 4;
  }

  // The corner whose child (u, v) is in; 3 for the middle triangle.
  std::size_t CornerNear() const {
    if (kind == RingKind::kTriangles) {
      if (u + v <= 0.5) return 0;
      if (u >= 0.5) return 1;
      return v >= 0.5 ? 2 : 3;
    }
    if (v <= 0.5) return u <= 0.5 ? 0 : 1;
    return u <= 0.5 ? 3 : 2;
  }

  // Those of the patch turned so that this corner is the first.
  PatchTurn ToCorner(std::size_t corner) const {
    constexpr PatchTurn kQuad[4] = {{}, {0, -1, 1, 0}, {-1, 0, 0, -1}, {0, 1, -1, 0}};
    constexpr PatchTurn kTriangle[3] = {{}, {0, -1, 1, -1}, {-1, 1, -1, 0}};
    return kind == RingKind::kQuads ? kQuad[corner] : kTriangle[corner];
  }

  // Enters the child CornerNear(), whose first corner is that corner, or in the middle triangle the
  // middle of the side that leaves corner 0. The child's u and v run twice as fast.
  void EnterChild() {
    const std::size_t near = CornerNear();
    if (near == sides()) return EnterMiddle();
    TurnTo(near);
    u *= 2;
    v *= 2;
  }

 private:
  void EnterMiddle() {
    turn.Compose({1, -1, 1, 0});
    const double w = std::max(0.0, 2 * (u + v) - 1);
    v = 1 - 2 * u;
    u = std::min(w, 1 - v);
  }

  void TurnTo(std::size_t corner) {
    turn.Compose(ToCorner(corner));
    if (corner == 0) return;
    const double a = u;
    const double b = v;
    if (kind == RingKind::kTriangles) {
      const double c = std::max(0.0, (1 - std::max(a, b)) - std::min(a, b));
      u = corner == 1 ? b : c;
      v = corner == 1 ? c : a;
      return;
    }
    u = corner == 1 ? b : (corner == 2 ? 1 - a : 1 - b);
    v = corner == 1 ? 1 - a : (corner == 2 ? 1 - b : a);
  }
};

}  // namespace limn
