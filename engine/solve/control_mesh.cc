// SPDX-License-Identifier: MIT
#include "engine/solve/control_mesh.h"

#include <algorithm>
#include <cstdint>

#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// Vertices whose control points are known before the solve.
absl::Status FixKnown(const Context& context, const ControlMeshProblem& problem,
                      LimitStencil* stencil) {
  const HalfEdgeMesh& mesh = problem.mesh;
  Buffer<std::uint8_t> fixed(mesh.vertex_count());
  LIMN_RETURN_IF_ERROR(ParallelFor(context, fixed.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      fixed[v] = mesh.IsBoundary(v) || !problem.plan.interpolated(v) ? 1 : 0;
    }
  }));
  return FixVertices(context, fixed, stencil);
}

}  // namespace

absl::StatusOr<BoundaryControl> SolveBoundary(const Context& context,
                                              const ControlMeshProblem& problem,
                                              const BoundaryProblem& boundary) {
  BoundaryControl control;
  const std::size_t size = boundary.curve.size();
  if (size == 0) return control;
  control.vertex.resize(size);
  control.point.resize(size);
  control.given.resize(size);
  control.interpolated.resize(size);
  Buffer<std::uint8_t> fixed(size);
  LIMN_RETURN_IF_ERROR(ParallelFor(context, size, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index v = problem.mesh.vertex()[boundary.curve.half_edge[i]];
      const bool corner = !boundary.corner.empty() && boundary.corner[i] != 0;
      control.vertex[i] = v;
      control.given[i] = problem.model_points[v];
      control.interpolated[i] = problem.plan.interpolated(v) ? 1 : 0;
      fixed[i] = control.interpolated[i] == 0 || corner ? 1 : 0;
    }
  }));
  const CurveProblem curves = {.curve = boundary.curve,
                               .points = control.given,
                               .fixed = fixed,
                               .stencil = boundary.stencil,
                               .vertex_weights = boundary.vertex_weights};
  LIMN_RETURN_IF_ERROR(SolveCurves(context, curves, absl::MakeSpan(control.point)));
  LIMN_RETURN_IF_ERROR(CurveResidual(context, curves, control.point, &control.residual));
  return control;
}

absl::StatusOr<SolveReport> SolveControlMesh(const Context& context,
                                             const ControlMeshProblem& problem,
                                             const BoundaryControl& boundary, InteriorSolve solve,
                                             absl::Span<Vec3> control) {
  absl::Span<const Vec3> points = problem.points;
  Buffer<Vec3> targets;
  if (!boundary.vertex.empty()) {
    targets.assign(points.begin(), points.end());
    for (std::size_t i = 0; i < boundary.vertex.size(); ++i) {
      targets[boundary.vertex[i]] = boundary.point[i] - problem.origin;
    }
    points = targets;
  }
  if (!boundary.vertex.empty() || !problem.plan.interpolates_all()) {
    LIMN_RETURN_IF_ERROR(FixKnown(context, problem, &solve.stencil));
  }
  LIMN_ASSIGN_OR_RETURN(SolveReport report, Solve(context,
                                                  {.mesh = problem.mesh,
                                                   .stencil = solve.stencil,
                                                   .points = points,
                                                   .scale = problem.scale},
                                                  solve.options, control));
  report.residual = std::max(report.residual, boundary.residual / problem.scale);
  return report;
}

}  // namespace limn
