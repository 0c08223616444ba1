// SPDX-License-Identifier: MIT
// Whether the interpolation problem of a Catmull-Clark surface is one that should be solved as it
// is. Its operator is singular where a closed component is 3-regular and bipartite and all its
// vertices are interpolated (alternating signs are taken to 0: cubes, even prisms), indefinite
// where vertices inside have valence 2, and nearly singular where almost all valences are 3; exact
// solutions are wild shapes then. The first two are told by the mesh, the last by a probe of the
// operator. All depend on the mesh, on what is interpolated and on what is sharp alone: not on
// points, tolerances, sweeps or methods. Source: the row's weights, Halstead, Kass and DeRose 1993.
#pragma once

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/scheme/sharpness.h"
#include "engine/stencil/limit_stencil.h"

namespace limn {

// Whether one of the first two cases above is there, among smooth vertices. level: T^0. Errors:
// CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over half-edges where every vertex of a component
// has valence 3, else less. Thread-safe.
[[nodiscard]] absl::StatusOr<bool> CatmullClarkIsSingular(const Context& context,
                                                          const SurfaceLevel& level,
                                                          const VertexPlan& plan);

// Equations of the vertices inside a mesh.
struct InteriorEquations {
  // T^0.
  const HalfEdgeMesh& mesh;
  const VertexPlan& plan;
  // As if nothing were sharp, all vertices interpolated.
  const LimitStencil& smooth;
  // Where something is.
  const WeightedRows& sharp;
};

// Whether they have an eigenvalue below kLeastRegularEigenvalue, as HasEigenvalueBelow sees it;
// without a look where a bound is proved. Sharp vertices whose own points outweigh the others in
// their rows by that much cannot carry one and count as known; the others, hardly sharp, as smooth.
// Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: that of HasEigenvalueBelow and of making the operator
// if no bound is proved. Thread-safe.
[[nodiscard]] absl::StatusOr<bool> IsNearlySingular(const Context& context,
                                                    const InteriorEquations& equations);

}  // namespace limn
