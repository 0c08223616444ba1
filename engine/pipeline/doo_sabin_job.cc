// SPDX-License-Identifier: MIT
#include "engine/pipeline/doo_sabin_job.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/fair.h"
#include "engine/constraints/perturb.h"
#include "engine/limit/doo_sabin_limit.h"
#include "engine/mesh/quad_split.h"
#include "engine/refine/boundary_curve.h"

namespace limn {

DooSabinJob::DooSabinJob(JobFrame* frame)
    : frame_(*frame),
      context_(frame->context),
      rule_(frame->options.rule.value_or(FirstRule::kModified)) {}

absl::Status DooSabinJob::Start(HalfEdgeMesh mesh) {
  LIMN_RETURN_IF_ERROR(ValidateDooSabinNormals(context_, frame_.options.constraints, mesh));
  LIMN_ASSIGN_OR_RETURN(BoundaryCurve boundary, FindBoundary(context_, mesh));
  boundary.origin = frame_.origin;
  patches_.emplace(
      DooSabinSurface{.mesh = std::move(mesh), .corners = {}, .boundary = std::move(boundary)});
  return absl::OkStatus();
}

absl::Status DooSabinJob::LimitPoints(absl::Span<const Vec3> control, absl::Span<Vec3> limits) {
  const HalfEdgeMesh& mesh = patches_->mesh;
  patches_->corners.resize(mesh.half_edge_count());
  const absl::Span<Vec3> corners = absl::MakeSpan(patches_->corners);
  LIMN_RETURN_IF_ERROR(FirstRefinement(context_, mesh, control, corners, rule_));
  BoundaryCurve curve = patches_->boundary;
  if (!curve.empty()) {
    Buffer<Vec3> points(curve.size());
    for (std::size_t i = 0; i < curve.size(); ++i) {
      points[i] = control[mesh.vertex()[curve.half_edge[i]]];
    }
    Buffer<std::uint8_t> free(curve.size());
    std::fill(free.begin(), free.end(), std::uint8_t{0});
    double unused = 0;
    LIMN_RETURN_IF_ERROR(PlaceBoundary(
        context_, {.mesh = mesh, .points = points, .control = points, .interpolated = free}, &curve,
        &unused));
  }
  return DooSabinLimit(context_, {.mesh = mesh, .fans = fans_, .k = 1, .boundary = &curve}, corners,
                       {.points = limits, .normals = {}, .vertices_only = true});
}

absl::Status DooSabinJob::FindControlMesh() {
  InterpolateResult& result = frame_.result;
  const ControlMeshProblem problem = frame_.Problem(patches_->mesh);
  LIMN_RETURN_IF_ERROR(FindBoundaryControl(problem));
  LIMN_ASSIGN_OR_RETURN(result.solve, SolveControlMesh(context_, problem, boundary_control_,
                                                       {.stencil = rule_ == FirstRule::kStandard
                                                                       ? DooSabinStandardStencil()
                                                                       : DooSabinModifiedStencil(),
                                                        .options = frame_.options.solve},
                                                       absl::MakeSpan(result.control_positions)));
  result.rule = rule_;
  return absl::OkStatus();
}

absl::Status DooSabinJob::StartSurface() {
  const InterpolateOptions& options = frame_.options;
  LIMN_RETURN_IF_ERROR(frame_.Stage("first_refinement", [&] {
    patches_->corners.resize(patches_->mesh.half_edge_count());
    return FirstRefinement(context_, patches_->mesh, frame_.result.control_positions,
                           absl::MakeSpan(patches_->corners), rule_);
  }));
  LIMN_RETURN_IF_ERROR(frame_.Stage("perturb", [&] {
    return PerturbToInterpolate(context_,
                                {.mesh = patches_->mesh,
                                 .points = frame_.points,
                                 .plan = &frame_.plan,
                                 .boundary = &patches_->boundary},
                                absl::MakeSpan(patches_->corners));
  }));
  if (options.fair) {
    LIMN_RETURN_IF_ERROR(frame_.Stage("fair", [&]() -> absl::Status {
      LIMN_ASSIGN_OR_RETURN(frame_.result.fairness,
                            Fair(context_, {.plan = &frame_.plan}, &*patches_));
      return absl::OkStatus();
    }));
  }
  KeepPatches();
  return absl::OkStatus();
}

void DooSabinJob::KeepPatches() {
  if (!frame_.options.keep_patches) return;
  frame_.result.patches = frame_.options.surface ? *patches_ : *std::move(patches_);
}

absl::StatusOr<ChordLevel> DooSabinJob::ChooseLevel(double tolerance) {
  return limn::ChooseLevel(context_, *patches_,
                           {.tolerance = tolerance, .finest = frame_.options.finest});
}

// From M^k to M^(k+1). What T^1 needs is there from the start: its vertices are the faces of M^1.
absl::Status DooSabinJob::Refine() {
  if (++level_ < 2) return absl::OkStatus();
  const std::uint32_t k = level_ - 1;
  if (k == 1) {
    LIMN_ASSIGN_OR_RETURN(fans_, FindExtraordinaryFans(context_, patches_->mesh));
  }
  Buffer<Vec3> refined(4 * patches_->mesh.half_edge_count());
  LIMN_RETURN_IF_ERROR(RefineDooSabin(
      context_, {.mesh = patches_->mesh, .fans = fans_, .k = k, .boundary = &patches_->boundary},
      patches_->corners, absl::MakeSpan(refined)));
  patches_->corners = std::move(refined);
  LIMN_ASSIGN_OR_RETURN(patches_->boundary,
                        RefineBoundary(context_, patches_->mesh, patches_->boundary));
  LIMN_ASSIGN_OR_RETURN(patches_->mesh, SplitIntoQuads(context_, patches_->mesh));
  return absl::OkStatus();
}

absl::Status DooSabinJob::Tessellate() {
  const HalfEdgeMesh& mesh = patches_->mesh;
  Tessellation& surface = frame_.result.surface;
  surface.level = level_;
  const bool given_faces = level_ == 0;
  const std::size_t vertices =
      mesh.vertex_count() + (given_faces ? 0 : mesh.edge_count() + mesh.face_count());
  surface.positions.resize(vertices);
  if (frame_.options.normals) surface.normals.resize(vertices);
  LIMN_RETURN_IF_ERROR(DooSabinLimit(context_,
                                     {.mesh = mesh,
                                      .fans = fans_,
                                      .k = std::max<std::uint32_t>(1, level_),
                                      .boundary = &patches_->boundary},
                                     patches_->corners,
                                     {.points = absl::MakeSpan(surface.positions),
                                      .normals = absl::MakeSpan(surface.normals),
                                      .vertices_only = given_faces}));
  LIMN_RETURN_IF_ERROR(MoveSurfaceBack());
  if (given_faces) {
    surface.face_begin = frame_.input.face_begin;
    surface.face_vertices = frame_.input.corner_vertex;
    return absl::OkStatus();
  }
  surface.arity = 4;
  surface.face_vertices.resize(4 * mesh.half_edge_count());
  return QuadVertices(context_, mesh, absl::MakeSpan(surface.face_vertices));
}

absl::Status DooSabinJob::FindBoundaryControl(const ControlMeshProblem& problem) {
  BoundaryCurve& curve = patches_->boundary;
  if (curve.empty()) return absl::OkStatus();
  BoundaryProblem boundary = {.curve = curve, .stencil = kQuadraticCurve};
  boundary.corner.resize(curve.size());
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Index v = problem.mesh.vertex()[curve.half_edge[i]];
    boundary.corner[i] = problem.mesh.valence(v) == 1 ? 1 : 0;
  }
  LIMN_ASSIGN_OR_RETURN(boundary_control_, SolveBoundary(context_, problem, boundary));
  return PlaceBoundary(context_,
                       {.mesh = problem.mesh,
                        .points = boundary_control_.given,
                        .control = boundary_control_.point,
                        .interpolated = boundary_control_.interpolated},
                       &curve, &boundary_control_.residual);
}

// The boundary's points are known in the model's frame, and are not to be rounded by the way.
absl::Status DooSabinJob::MoveSurfaceBack() {
  if (!frame_.moved) return absl::OkStatus();
  Buffer<Vec3>& points = frame_.result.surface.positions;
  LIMN_RETURN_IF_ERROR(MoveBack(frame_, absl::MakeSpan(points)));
  const BoundaryCurve& curve = patches_->boundary;
  const HalfEdgeMesh& mesh = patches_->mesh;
  return ParallelFor(context_, curve.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index h = curve.half_edge[i];
      points[mesh.vertex()[h]] = curve.centre[i];
      if (level_ > 0) {
        points[mesh.vertex_count() + mesh.edge()[h]] = 0.5 * (curve.start[i] + curve.end[i]);
      }
    }
  });
}

std::unique_ptr<SchemeJob> MakeDooSabinJob(JobFrame* frame) {
  return std::make_unique<DooSabinJob>(frame);
}

}  // namespace limn
