// SPDX-License-Identifier: MIT
#include "engine/scheme/limit_stencil.h"

#include <algorithm>

#include "engine/base/parallel.h"

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

LimitStencil DooSabinStandardStencil() {
  LimitStencil stencil;
  stencil.rows = {{.vertex = 0, .edges = 0, .faces = 1}};
  stencil.face_rule = FaceRule::kDooSabinImage;
  stencil.spectrum_low = 0.25;
  stencil.spectrum_high = 1;
  return stencil;
}

absl::Status FixVertices(const Context& context, absl::Span<const std::uint8_t> fixed,
                         LimitStencil* stencil) {
  const auto identity = static_cast<std::uint16_t>(stencil->rows.size());
  stencil->rows.push_back({.vertex = 1, .edges = 0, .faces = 0});
  const bool same_row = stencil->row_of.empty();
  stencil->row_of.resize(fixed.size());
  std::uint16_t* const row = stencil->row_of.data();
  return ParallelFor(context, fixed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      if (same_row) row[v] = 0;
      if (fixed[v] != 0) row[v] = identity;
    }
  });
}

}  // namespace limn
