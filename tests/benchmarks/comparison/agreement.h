// SPDX-License-Identifier: MIT
// Whether contestants found the same points, whatever their order.
#pragma once

#include <array>
#include <vector>

#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {

struct Difference {
  // Over the diagonal of the bounding box; infinite where the numbers of points differ.
  double points = 0;
  // Of unit normals; 0 where there are none.
  double normals = 0;
};

// An answer in order, or its coordinates sorted along x, y, z and a fourth, skew direction. Where
// points have partners at a distance of at most d, so have their sorted coordinates.
class Fingerprint {
 public:
  Fingerprint() = default;
  explicit Fingerprint(const Answer& answer);

  Difference From(const Fingerprint& reference) const;

 private:
  bool in_order_ = false;
  double diagonal_ = 1;
  std::array<std::vector<double>, 4> points_;
  // Empty without normals.
  std::array<std::vector<double>, 4> normals_;
};

}  // namespace limn::comparison
