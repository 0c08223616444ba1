// SPDX-License-Identifier: MIT
// A point of a spline patch and its first derivatives.
#pragma once

#include "engine/base/vec3.h"

namespace limn {

struct SplineJet {
  Vec3 point;
  Vec3 du;
  Vec3 dv;
};

}  // namespace limn
