// SPDX-License-Identifier: MIT
// Whether the interpolation problem of a Catmull-Clark surface is one that should be solved as it
// is. Its operator is singular where a closed component is 3-regular and bipartite and all its
// vertices are interpolated (alternating signs are taken to 0: cubes, even prisms), indefinite
// where vertices inside have valence 2, and nearly singular where almost all valences are 3; exact
// solutions are wild shapes then. The first two are told by the mesh, here; the last by the solve
// (SolveReport::trouble). Source: the row's weights, Halstead, Kass and DeRose 1993.
#pragma once

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/scheme/sharpness.h"

namespace limn {

// Whether one of the first two cases above is there, among smooth vertices. level: T^0. Errors:
// CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over half-edges where every vertex of a component
// has valence 3, else less. Thread-safe.
[[nodiscard]] absl::StatusOr<bool> CatmullClarkIsSingular(const Context& context,
                                                          const SurfaceLevel& level,
                                                          const VertexPlan& plan);

}  // namespace limn
