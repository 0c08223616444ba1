// SPDX-License-Identifier: MIT
// The affine map that takes a surface's point, tangents and normal to those that are wanted.
// Source: Chen et al., "Interpolating meshes of arbitrary topology by Catmull-Clark surfaces",
// section 3 (blending surfaces by rotation, non-uniform scale and translation).
#pragma once

#include <optional>

#include "engine/base/vec3.h"
#include "engine/constraints/blend_targets.h"
#include "engine/limit/patch_sample.h"

namespace limn {

struct Matrix3 {
  Vec3 column[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  friend Vec3 operator*(const Matrix3& m, const Vec3& a) {
    return a.x * m.column[0] + a.y * m.column[1] + a.z * m.column[2];
  }
};

// x -> to + linear (x - from).
struct AffineMap {
  Vec3 from = {0, 0, 0};
  Vec3 to = {0, 0, 0};
  Matrix3 linear;

  // How far it moves x. Exact where linear is the identity.
  Vec3 Move(const Vec3& x) const {
    const Vec3 way = x - from;
    return (to - from) + (linear * way - way);
  }
};

// The map of what `target` asks for, from the surface as it is there. By what is asked of tangents:
//   nothing: a translation;
//   the normal: the smallest rotation of the normal's line;
//   one derivative: the smallest rotation of that derivative, and a scale along it; with the normal
//     too the rotation of both;
//   both derivatives: the linear map of both and of the unit normal.
// nullopt: tangents are asked for where the surface has none. Cost: constant.
[[nodiscard]] std::optional<AffineMap> MapTo(const BlendTarget& target, const PatchSample& now);

}  // namespace limn
