// SPDX-License-Identifier: MIT
// Checked constraints, arranged by vertex for the loops that look them up.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/constraints/constraints.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// A vertex with a normal or a shape handle.
struct SpecialVertex {
  Index vertex = 0;
  // Unit length, or (0, 0, 0): free.
  Vec3 normal = {0, 0, 0};
  double handle = 1;

  bool has_normal() const { return normal != Vec3{0, 0, 0}; }
};

class VertexPlan {
 public:
  // Nothing but that all vertices are interpolated.
  VertexPlan() = default;
  // constraints: as ValidateConstraints accepts them for so many vertices. Cost: linear in the
  // vertices when there are constraints; sorts the special ones.
  VertexPlan(const Constraints& constraints, std::size_t vertex_count);

  // Whether every vertex is interpolated.
  bool interpolates_all() const { return all_; }
  bool interpolated(std::size_t v) const {
    return flags_.empty() || (flags_[v] & kInterpolated) != 0;
  }
  bool special(std::size_t v) const { return !flags_.empty() && (flags_[v] & kSpecial) != 0; }
  // In ascending order of vertices.
  const std::vector<SpecialVertex>& specials() const { return specials_; }
  // What is asked of a vertex, special or not. Cost: logarithmic in the special ones.
  SpecialVertex At(Index v) const;

 private:
  static constexpr std::uint8_t kInterpolated = 1;
  static constexpr std::uint8_t kSpecial = 2;

  bool all_ = true;
  // Empty without constraints.
  Buffer<std::uint8_t> flags_;
  std::vector<SpecialVertex> specials_;
};

}  // namespace limn
