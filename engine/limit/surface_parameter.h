// SPDX-License-Identifier: MIT
// A point of the parameter domain of a limit surface; engine/limit/evaluate.h says what it means.
#pragma once

#include "engine/mesh/polygon_mesh.h"

namespace limn {

// A point of the parameter domain. Both coordinates in [0, 1], denormal numbers too.
struct SurfaceParameter {
  Index face = 0;
  // Of the face, 0 to arity - 1.
  Index corner = 0;
  double u = 0;
  double v = 0;
};

}  // namespace limn
