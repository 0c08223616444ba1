// SPDX-License-Identifier: MIT
// The control mesh of a surface of any scheme, open or closed: boundary curves first, which depend
// on boundary vertices only, then the interior with the curves' control points fixed.
// Sources: Zheng and Cai 2005, sections 2 and 3.1 to 3.2; for boundaries the one-dimensional case.
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/refine/boundary_curve.h"
#include "engine/solve/curve_solve.h"
#include "engine/solve/solve.h"
#include "engine/stencil/limit_stencil.h"

namespace limn {

// The boundary of a mesh as an interpolation problem of its own. Vertices are numbered along the
// curve: vertex i is the one that boundary half-edge i leaves.
struct BoundaryProblem {
  // From FindBoundary.
  const BoundaryCurve& curve;
  CurveStencil stencil;
  // Vertices that keep their given point beside those that are not interpolated: corners. Empty:
  // none.
  Buffer<std::uint8_t> corner = {};
  // As CurveProblem::vertex_weights.
  Buffer<double> vertex_weights = {};
};

struct ControlMeshProblem {
  // T^0.
  const HalfEdgeMesh& mesh;
  // Given points in the model's frame, and relative to an origin.
  absl::Span<const Vec3> model_points;
  absl::Span<const Vec3> points;
  Vec3 origin = {0, 0, 0};
  // Which of them are interpolated. The others keep their given points as control points.
  const VertexPlan& plan;
  // Diagonal of the bounding box, greater than 0.
  double scale = 1;
};

// Control points of the boundary's vertices, in the model's frame, and the points to interpolate.
// Plain data; empty for closed meshes.
struct BoundaryControl {
  // That of vertex[i] is point[i].
  Buffer<Index> vertex;
  Buffer<Vec3> point;
  Buffer<Vec3> given;
  Buffer<std::uint8_t> interpolated;
  // Largest coordinate of given less limit point, where it is interpolated.
  double residual = 0;
};

// Solves for the boundary's control points. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: some 50
// operations per boundary vertex.
[[nodiscard]] absl::StatusOr<BoundaryControl> SolveBoundary(const Context& context,
                                                            const ControlMeshProblem& problem,
                                                            const BoundaryProblem& boundary);

// How the rest is found.
struct InteriorSolve {
  // Of the scheme, for all vertices; used up.
  LimitStencil stencil;
  const SolveOptions& options;
};

// Solves for the control points, relative to the problem's origin, one per vertex: those of the
// boundary and of vertices that are not interpolated are known, and get a row of identity. The
// report's residual counts the boundary's too. Errors, cost and progress as Solve.
[[nodiscard]] absl::StatusOr<SolveReport> SolveControlMesh(const Context& context,
                                                           const ControlMeshProblem& problem,
                                                           const BoundaryControl& boundary,
                                                           InteriorSolve solve,
                                                           absl::Span<Vec3> control);

}  // namespace limn
