// SPDX-License-Identifier: MIT
// What evaluation finds at one parameter of a patch, for every scheme.
#pragma once

#include "engine/base/vec3.h"

namespace limn {

// Point, first derivatives along u and v, and the normal: unit length, or (0, 0, 0) where the
// derivatives span no plane.
struct PatchSample {
  Vec3 point;
  Vec3 du;
  Vec3 dv;
  Vec3 normal;
};

}  // namespace limn
