// SPDX-License-Identifier: MIT
// The control mesh of a Doo-Sabin surface, open or closed: boundary curves first, which depend on
// boundary vertices only, then the interior with the curves' control points fixed.
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
#include "engine/refine/doo_sabin_rule.h"
#include "engine/solve/solve.h"

namespace limn {

struct ControlMeshProblem {
  // T^0.
  const HalfEdgeMesh& mesh;
  FirstRule rule = FirstRule::kModified;
  // Given points in the model's frame, and relative to the curve's origin.
  absl::Span<const Vec3> model_points;
  absl::Span<const Vec3> points;
  // Which of them are interpolated. The others keep their given points as control points.
  const VertexPlan& plan;
  // Diagonal of the bounding box, greater than 0.
  double scale = 1;
};

// Control points of the boundary's vertices: that of vertex[i] is point[i], in the model's frame.
struct BoundaryControl {
  Buffer<Index> vertex;
  Buffer<Vec3> point;
};

struct ControlMeshReport {
  // Of the interior; its residual counts the curves' too.
  SolveReport solve;
  BoundaryControl boundary;
};

// Solves for the control points, relative to the curve's origin, one per vertex, and sets the
// points of the curve, which is the mesh's boundary as FindBoundary finds it, with its origin.
// Errors, cost and progress as Solve; curves cost some 50 operations per boundary vertex.
[[nodiscard]] absl::StatusOr<ControlMeshReport> SolveControlMesh(const Context& context,
                                                                 const ControlMeshProblem& problem,
                                                                 const SolveOptions& options,
                                                                 BoundaryCurve* curve,
                                                                 absl::Span<Vec3> control);

}  // namespace limn
