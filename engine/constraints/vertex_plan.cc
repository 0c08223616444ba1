// SPDX-License-Identifier: MIT
#include "engine/constraints/vertex_plan.h"

#include <algorithm>

namespace limn {

VertexPlan::VertexPlan(const Constraints& constraints, std::size_t vertex_count)
    : all_(constraints.interpolates_all()) {
  if (all_ && constraints.normals.empty() && constraints.shape_handles.empty()) return;
  flags_.assign(vertex_count, all_ ? kInterpolated : std::uint8_t{0});
  if (constraints.interpolate.has_value()) {
    for (const Index v : *constraints.interpolate) flags_[v] = kInterpolated;
  }
  for (const NormalConstraint& normal : constraints.normals) {
    flags_[normal.vertex] |= kSpecial;
    specials_.push_back({.vertex = normal.vertex, .normal = NormalizedOrZero(normal.normal)});
  }
  for (const ShapeHandle& handle : constraints.shape_handles) {
    flags_[handle.vertex] |= kSpecial;
    specials_.push_back({.vertex = handle.vertex, .handle = handle.value});
  }
  std::sort(specials_.begin(), specials_.end(),
            [](const SpecialVertex& a, const SpecialVertex& b) { return a.vertex < b.vertex; });
  // A vertex with both has one entry of each.
  std::size_t last = 0;
  for (std::size_t i = 1; i < specials_.size(); ++i) {
    if (specials_[i].vertex != specials_[last].vertex) {
      specials_[++last] = specials_[i];
      continue;
    }
    if (specials_[i].has_normal()) specials_[last].normal = specials_[i].normal;
    specials_[last].handle *= specials_[i].handle;
  }
  if (!specials_.empty()) specials_.resize(last + 1);
}

SpecialVertex VertexPlan::At(Index v) const {
  if (!special(v)) return {.vertex = v};
  return *std::lower_bound(specials_.begin(), specials_.end(), v,
                           [](const SpecialVertex& a, Index b) { return a.vertex < b; });
}

}  // namespace limn
