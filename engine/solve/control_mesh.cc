// SPDX-License-Identifier: MIT
#include "engine/solve/control_mesh.h"

#include <algorithm>
#include <cstdint>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/scheme/limit_stencil.h"
#include "engine/solve/curve_solve.h"

namespace limn {
namespace {

absl::Status SolveBoundary(const Context& context, const ControlMeshProblem& problem,
                           BoundaryCurve* curve, BoundaryControl* control, double* residual) {
  const std::size_t size = curve->size();
  Buffer<Vec3> given(size);
  Buffer<std::uint8_t> interpolated(size);
  Buffer<std::uint8_t> fixed(size);
  control->vertex.resize(size);
  control->point.resize(size);
  LIMN_RETURN_IF_ERROR(ParallelFor(context, size, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index v = problem.mesh.vertex()[curve->half_edge[i]];
      control->vertex[i] = v;
      given[i] = problem.model_points[v];
      interpolated[i] = problem.plan.interpolated(v) ? 1 : 0;
      fixed[i] = interpolated[i] == 0 || problem.mesh.valence(v) == 1 ? 1 : 0;
    }
  }));
  LIMN_RETURN_IF_ERROR(SolveCurves(context, {.curve = *curve, .points = given, .fixed = fixed},
                                   absl::MakeSpan(control->point)));
  return PlaceBoundary(context,
                       {.mesh = problem.mesh,
                        .points = given,
                        .control = control->point,
                        .interpolated = interpolated},
                       curve, residual);
}

// Vertices whose control points are known before the solve.
absl::Status FixKnown(const Context& context, const ControlMeshProblem& problem,
                      LimitStencil* stencil) {
  const HalfEdgeMesh& mesh = problem.mesh;
  Buffer<std::uint8_t> fixed(mesh.vertex_count());
  LIMN_RETURN_IF_ERROR(ParallelFor(context, fixed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const bool boundary = mesh.twin()[mesh.vertex_half_edge()[v]] == kNoIndex;
      fixed[v] = boundary || !problem.plan.interpolated(v) ? 1 : 0;
    }
  }));
  return FixVertices(context, fixed, stencil);
}

}  // namespace

absl::StatusOr<ControlMeshReport> SolveControlMesh(const Context& context,
                                                   const ControlMeshProblem& problem,
                                                   const SolveOptions& options,
                                                   BoundaryCurve* curve, absl::Span<Vec3> control) {
  ControlMeshReport report;
  LimitStencil stencil =
      problem.rule == FirstRule::kStandard ? DooSabinStandardStencil() : DooSabinModifiedStencil();
  double curve_residual = 0;
  absl::Span<const Vec3> points = problem.points;
  Buffer<Vec3> targets;
  if (!curve->empty()) {
    LIMN_RETURN_IF_ERROR(SolveBoundary(context, problem, curve, &report.boundary, &curve_residual));
    targets.assign(points.begin(), points.end());
    for (std::size_t i = 0; i < curve->size(); ++i) {
      targets[report.boundary.vertex[i]] = report.boundary.point[i] - curve->origin;
    }
    points = targets;
  }
  if (!curve->empty() || !problem.plan.interpolates_all()) {
    LIMN_RETURN_IF_ERROR(FixKnown(context, problem, &stencil));
  }
  LIMN_ASSIGN_OR_RETURN(
      report.solve,
      Solve(context,
            {.mesh = problem.mesh, .stencil = stencil, .points = points, .scale = problem.scale},
            options, control));
  report.solve.residual = std::max(report.solve.residual, curve_residual / problem.scale);
  return report;
}

}  // namespace limn
