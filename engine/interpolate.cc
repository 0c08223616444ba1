// SPDX-License-Identifier: MIT
#include "engine/interpolate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/fair.h"
#include "engine/constraints/perturb.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/limit/doo_sabin_limit.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/validate.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/quad_split.h"
#include "engine/solve/control_mesh.h"

namespace limn {
namespace {

// Runs f() as a stage: progress when it begins, its time when it ends.
template <class F>
absl::Status RunStage(const Context& context, std::string_view stage,
                      std::vector<StageTime>* stages, const F& f) {
  context.Report({.stage = stage});
  const auto begin = std::chrono::steady_clock::now();
  absl::Status status = f();
  const std::chrono::duration<double, std::milli> elapsed =
      std::chrono::steady_clock::now() - begin;
  stages->push_back({.stage = stage, .milliseconds = elapsed.count()});
  return status;
}

absl::Status CheckBytes(const Context& context, const PolygonMesh& mesh,
                        const InterpolateOptions& options, std::uint64_t boundary_edges) {
  const std::uint64_t bytes = EstimateBytes(mesh.vertex_count(), mesh.face_count(),
                                            mesh.corner_count(), options, boundary_edges);
  if (bytes <= context.limits().max_bytes) return absl::OkStatus();
  return MakeError(absl::StrCat("the job would need ", bytes, " bytes, the limit is ",
                                context.limits().max_bytes),
                   {.reason = Reason::kLimitExceeded,
                    .field = "surface.level",
                    .remedy = "Choose a lower level, send a smaller mesh or raise the limit",
                    .limit = "max-job-bytes"});
}

absl::Status CheckOptions(const Context& context, const PolygonMesh& mesh,
                          const InterpolateOptions& options) {
  if (options.scheme != Scheme::kDooSabin) {
    return MakeError(
        "this scheme is not built yet",
        {.reason = Reason::kUnimplemented, .field = "scheme", .remedy = "Choose Doo-Sabin"});
  }
  if (options.chord_tolerance.has_value()) {
    return MakeError("tessellation to a chord tolerance is not built yet",
                     {.reason = Reason::kUnimplemented,
                      .field = "surface.chord_tolerance",
                      .remedy = "Choose a level"});
  }
  LIMN_RETURN_IF_ERROR(ValidateSolveOptions(options.solve));
  if (options.surface && options.level > context.limits().max_level) {
    return MakeError(absl::StrCat("the level is ", options.level),
                     {.reason = Reason::kInvalidOption,
                      .field = "surface.level",
                      .remedy = absl::StrCat("It must be at most ", context.limits().max_level)});
  }
  // Half-edges of the finest connectivity, T^(level - 1).
  const double half_edges = std::ldexp(static_cast<double>(mesh.corner_count()),
                                       options.level < 2 ? 0 : 2 * (options.level - 1));
  if (options.surface && half_edges >= kNoIndex) {
    return MakeError(absl::StrCat("the refined mesh would have ", half_edges, " half-edges"),
                     {.reason = Reason::kLimitExceeded,
                      .field = "surface.level",
                      .remedy = "Choose a lower level"});
  }
  return CheckBytes(context, mesh, options, 0);
}

// The stages of one job, in order, and the arrays they hand on.
class Pipeline {
 public:
  Pipeline(const Context& context, const PolygonMesh& input, const InterpolateOptions& options)
      : context_(context), input_(input), options_(options) {}

  absl::StatusOr<InterpolateResult> Run() {
    LIMN_RETURN_IF_ERROR(CheckOptions(context_, input_, options_));
    LIMN_RETURN_IF_ERROR(Stage("build", [&] { return Build(); }));
    LIMN_RETURN_IF_ERROR(Stage("solve", [&] { return FindControlMesh(); }));
    if (options_.surface || options_.keep_patches) LIMN_RETURN_IF_ERROR(MakePatches());
    if (options_.keep_patches)
      result_.patches = options_.surface ? *patches_ : *std::move(patches_);
    if (options_.surface) LIMN_RETURN_IF_ERROR(MakeSurface());
    LIMN_RETURN_IF_ERROR(MoveControlMeshBack());
    return std::move(result_);
  }

 private:
  template <class F>
  absl::Status Stage(std::string_view name, const F& f) {
    return RunStage(context_, name, &result_.stages, f);
  }

  absl::Status Build() {
    BoundingBox box;
    LIMN_RETURN_IF_ERROR(ValidatePositions(context_, input_.positions, &box));
    scale_ = box.diagonal() > 0 ? box.diagonal() : 1;
    LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh mesh, HalfEdgeMesh::Build(context_, input_));
    LIMN_RETURN_IF_ERROR(ValidateConstraints(context_, options_.constraints, mesh.vertex_count()));
    plan_ = VertexPlan(options_.constraints, mesh.vertex_count());
    if (mesh.boundary_edge_count() > 0) {
      LIMN_RETURN_IF_ERROR(CheckBytes(context_, input_, options_, mesh.boundary_edge_count()));
    }
    LIMN_ASSIGN_OR_RETURN(BoundaryCurve boundary, FindBoundary(context_, mesh));
    patches_.emplace(
        DooSabinSurface{.mesh = std::move(mesh), .corners = {}, .boundary = std::move(boundary)});
    return MoveToOrigin(box);
  }

  // Far from the origin coordinates leave few bits for the shape, and rounding alone moves points
  // by more than a solve's tolerance. The job then runs on points around the origin.
  absl::Status MoveToOrigin(const BoundingBox& box) {
    constexpr double kFar = 64;
    const Vec3 middle = 0.5 * box.min + 0.5 * box.max;
    points_ = input_.positions;
    if (MaxAbs(middle) <= kFar * box.diagonal()) return absl::OkStatus();
    patches_->boundary.origin = middle;
    moved_ = true;
    moved_points_.resize(points_.size());
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, points_.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) moved_points_[v] = input_.positions[v] - middle;
        }));
    points_ = moved_points_;
    return absl::OkStatus();
  }

  absl::Status FindControlMesh() {
    result_.control_positions.resize(input_.vertex_count());
    const ControlMeshProblem problem = {.mesh = patches_->mesh,
                                        .rule = options_.rule,
                                        .model_points = input_.positions,
                                        .points = points_,
                                        .plan = plan_,
                                        .scale = scale_};
    LIMN_ASSIGN_OR_RETURN(ControlMeshReport report,
                          SolveControlMesh(context_, problem, options_.solve, &patches_->boundary,
                                           absl::MakeSpan(result_.control_positions)));
    result_.solve = report.solve;
    boundary_control_ = std::move(report.boundary);
    return absl::OkStatus();
  }

  absl::Status MakePatches() {
    DooSabinSurface& patches = *patches_;
    LIMN_RETURN_IF_ERROR(Stage("first_refinement", [&] {
      patches.corners.resize(patches.mesh.half_edge_count());
      return FirstRefinement(context_, patches.mesh, result_.control_positions,
                             absl::MakeSpan(patches.corners), options_.rule);
    }));
    LIMN_RETURN_IF_ERROR(Stage("perturb", [&] {
      return PerturbToInterpolate(
          context_,
          {.mesh = patches.mesh, .points = points_, .plan = &plan_, .boundary = &patches.boundary},
          absl::MakeSpan(patches.corners));
    }));
    if (!options_.fair) return absl::OkStatus();
    return Stage("fair", [&]() -> absl::Status {
      LIMN_ASSIGN_OR_RETURN(result_.fairness, Fair(context_, {.plan = &plan_}, &patches));
      return absl::OkStatus();
    });
  }

  absl::Status MakeSurface() {
    LIMN_RETURN_IF_ERROR(Stage("refine", [&] { return Refine(); }));
    return Stage("limit", [&] { return Tessellate(); });
  }

  // From M^1 to M^level; patches_ ends as T^(level - 1) with the points of M^level.
  absl::Status Refine() {
    if (options_.level < 2) return absl::OkStatus();
    LIMN_ASSIGN_OR_RETURN(fans_, FindExtraordinaryFans(context_, patches_->mesh));
    for (std::uint32_t k = 1; k < options_.level; ++k) {
      DooSabinSurface& coarse = *patches_;
      Buffer<Vec3> refined(4 * coarse.mesh.half_edge_count());
      LIMN_RETURN_IF_ERROR(RefineDooSabin(
          context_, {.mesh = coarse.mesh, .fans = fans_, .k = k, .boundary = &coarse.boundary},
          coarse.corners, absl::MakeSpan(refined)));
      coarse.corners = std::move(refined);
      LIMN_ASSIGN_OR_RETURN(coarse.boundary,
                            RefineBoundary(context_, coarse.mesh, coarse.boundary));
      LIMN_ASSIGN_OR_RETURN(coarse.mesh, SplitIntoQuads(context_, coarse.mesh));
      context_.Report(
          {.stage = "refine", .fraction = static_cast<double>(k) / (options_.level - 1)});
    }
    return absl::OkStatus();
  }

  absl::Status Tessellate() {
    const HalfEdgeMesh& mesh = patches_->mesh;
    Tessellation& surface = result_.surface;
    surface.level = options_.level;
    const bool given_faces = options_.level == 0;
    const std::size_t vertices =
        mesh.vertex_count() + (given_faces ? 0 : mesh.edge_count() + mesh.face_count());
    surface.positions.resize(vertices);
    if (options_.normals) surface.normals.resize(vertices);
    LIMN_RETURN_IF_ERROR(DooSabinLimit(context_,
                                       {.mesh = mesh,
                                        .fans = fans_,
                                        .k = std::max<std::uint32_t>(1, options_.level),
                                        .boundary = &patches_->boundary},
                                       patches_->corners,
                                       {.points = absl::MakeSpan(surface.positions),
                                        .normals = absl::MakeSpan(surface.normals),
                                        .vertices_only = given_faces}));
    LIMN_RETURN_IF_ERROR(MoveSurfaceBack());
    if (given_faces) {
      surface.face_begin = input_.face_begin;
      surface.face_vertices = input_.corner_vertex;
      return absl::OkStatus();
    }
    surface.arity = 4;
    surface.face_vertices.resize(4 * mesh.half_edge_count());
    return QuadVertices(context_, mesh, absl::MakeSpan(surface.face_vertices));
  }

  absl::Status MoveBack(absl::Span<Vec3> points) const {
    const Vec3 origin = patches_->origin();
    return ParallelFor(context_, points.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) points[i] += origin;
    });
  }

  // The boundary's points are known in the model's frame, and are not to be rounded by the way.
  absl::Status MoveSurfaceBack() {
    if (!moved_) return absl::OkStatus();
    Buffer<Vec3>& points = result_.surface.positions;
    LIMN_RETURN_IF_ERROR(MoveBack(absl::MakeSpan(points)));
    const BoundaryCurve& curve = patches_->boundary;
    const HalfEdgeMesh& mesh = patches_->mesh;
    return ParallelFor(context_, curve.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Index h = curve.half_edge[i];
        points[mesh.vertex()[h]] = curve.centre[i];
        if (options_.level > 0) {
          points[mesh.vertex_count() + mesh.edge()[h]] = 0.5 * (curve.start[i] + curve.end[i]);
        }
      }
    });
  }

  absl::Status MoveControlMeshBack() {
    if (!moved_) return absl::OkStatus();
    LIMN_RETURN_IF_ERROR(MoveBack(absl::MakeSpan(result_.control_positions)));
    for (std::size_t i = 0; i < boundary_control_.vertex.size(); ++i) {
      result_.control_positions[boundary_control_.vertex[i]] = boundary_control_.point[i];
    }
    return absl::OkStatus();
  }

  const Context& context_;
  const PolygonMesh& input_;
  const InterpolateOptions& options_;
  InterpolateResult result_;
  double scale_ = 1;
  VertexPlan plan_;
  // The points to interpolate: the input's, or those moved to the origin.
  absl::Span<const Vec3> points_;
  bool moved_ = false;
  Buffer<Vec3> moved_points_;
  BoundaryControl boundary_control_;
  // T^(k-1) and the points of M^k of the current level k.
  std::optional<DooSabinSurface> patches_;
  ExtraordinaryFans fans_;
};

}  // namespace

absl::StatusOr<InterpolateResult> Interpolate(const Context& context, const PolygonMesh& mesh,
                                              const InterpolateOptions& options) {
  try {
    return Pipeline(context, mesh, options).Run();
  } catch (const std::bad_alloc&) {
    return MakeError("the system has no more memory for this job",
                     {.reason = Reason::kOutOfMemory,
                      .remedy = "Choose a lower level, send a smaller mesh or try again later"});
  }
}

}  // namespace limn
