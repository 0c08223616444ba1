// SPDX-License-Identifier: MIT
// Constraints on a surface that are too close to each other to be met one by one: the smallest
// smooth movement of control points that meets all of them.
#pragma once

#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/limit/primal_surface.h"
#include "engine/limit/surface_parameter.h"

namespace limn {

// What the surface has to be at a place; the point always counts.
struct JointAim {
  SurfaceParameter place = {};
  Vec3 point = {0, 0, 0};
  bool has_du = false;
  Vec3 du = {0, 0, 0};
  bool has_dv = false;
  Vec3 dv = {0, 0, 0};
  // Control points that the surface depends on there, all of them.
  std::vector<Index> support = {};
};

struct JointProblem {
  std::vector<JointAim> aims;
  // Control points that may move, each once, and in (0, 1] how readily.
  std::vector<Index> vertices;
  std::vector<double> weights;
};

// Moves control points of the surface so that it meets the aims, as far as it can: when they
// contradict each other the sum of squares of what is left is smallest. Whether they are met is for
// the caller to see. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: the evaluation of a third of all
// supports; for few aims and points a dense decomposition, of 2^18 entries at the most; else
// conjugate gradients on the sparse normal equations, linear in aims and points for each step, up
// to 5,000 steps. Deterministic; not thread-safe for the same surface.
[[nodiscard]] absl::Status MeetJointly(const Context& context, const JointProblem& problem,
                                       PrimalSurface* surface);

}  // namespace limn
