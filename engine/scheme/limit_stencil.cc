// SPDX-License-Identifier: MIT
#include "engine/scheme/limit_stencil.h"

#include <algorithm>

namespace limn {

bool LimitStencil::uses_edges() const {
  return std::any_of(rows.begin(), rows.end(), [](const LimitRow& r) { return r.edges != 0; });
}

LimitStencil DooSabinModifiedStencil() {
  LimitStencil stencil;
  stencil.rows = {{.vertex = 0.5, .edges = 0, .faces = 0.5}};
  stencil.spectrum_low = 0.5;
  stencil.spectrum_high = 1;
  return stencil;
}

}  // namespace limn
