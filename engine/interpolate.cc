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
#include "engine/constraints/perturb.h"
#include "engine/limit/doo_sabin_limit.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/validate.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/quad_split.h"
#include "engine/scheme/limit_stencil.h"

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

absl::Status CheckOptions(const Context& context, const PolygonMesh& mesh,
                          const InterpolateOptions& options) {
  if (options.scheme != Scheme::kDooSabin) {
    return MakeError(
        "this scheme is not built yet",
        {.reason = Reason::kUnimplemented, .field = "scheme", .remedy = "Choose Doo-Sabin"});
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
  const std::uint64_t bytes =
      EstimateBytes(mesh.vertex_count(), mesh.face_count(), mesh.corner_count(), options);
  if (bytes > context.limits().max_bytes) {
    return MakeError(absl::StrCat("the job would need ", bytes, " bytes, the limit is ",
                                  context.limits().max_bytes),
                     {.reason = Reason::kLimitExceeded,
                      .field = "surface.level",
                      .remedy = "Choose a lower level, send a smaller mesh or raise the limit"});
  }
  return absl::OkStatus();
}

absl::Status CheckClosed(const HalfEdgeMesh& mesh) {
  if (mesh.boundary_edge_count() == 0) return absl::OkStatus();
  const auto first = std::find(mesh.twin().begin(), mesh.twin().end(), kNoIndex);
  const auto half_edge = static_cast<std::size_t>(first - mesh.twin().begin());
  const Index face = mesh.face()[half_edge];
  return MakeError(
      absl::StrCat("open mesh: ", mesh.boundary_edge_count(),
                   " boundary edges, the first leaves vertex ", mesh.vertex()[half_edge],
                   " in face ", face),
      {.reason = Reason::kOpenMesh,
       .field = "mesh.faces",
       .index = face,
       .remedy = "Only closed meshes can be interpolated; close the boundary with faces"});
}

// The stages of one job, in order, and the arrays they hand on.
class Pipeline {
 public:
  Pipeline(const Context& context, const PolygonMesh& input, const InterpolateOptions& options)
      : context_(context), input_(input), options_(options) {}

  absl::StatusOr<InterpolateResult> Run() {
    LIMN_RETURN_IF_ERROR(CheckOptions(context_, input_, options_));
    LIMN_RETURN_IF_ERROR(Stage("build", [&] { return Build(); }));
    LIMN_RETURN_IF_ERROR(Stage("solve", [&] { return SolveControlMesh(); }));
    if (options_.surface) LIMN_RETURN_IF_ERROR(MakeSurface());
    LIMN_RETURN_IF_ERROR(MoveBack(absl::MakeSpan(result_.control_positions)));
    LIMN_RETURN_IF_ERROR(MoveBack(absl::MakeSpan(result_.surface.positions)));
    return std::move(result_);
  }

 private:
  absl::Status MakeSurface() {
    LIMN_RETURN_IF_ERROR(Stage("first_refinement", [&] {
      corners_.resize(mesh_->half_edge_count());
      return FirstRefinement(context_, *mesh_, result_.control_positions, absl::MakeSpan(corners_));
    }));
    LIMN_RETURN_IF_ERROR(Stage("perturb", [&] {
      return PerturbToInterpolate(context_, *mesh_, points_, absl::MakeSpan(corners_));
    }));
    LIMN_RETURN_IF_ERROR(Stage("refine", [&] { return Refine(); }));
    return Stage("limit", [&] { return Tessellate(); });
  }

  template <class F>
  absl::Status Stage(std::string_view name, const F& f) {
    return RunStage(context_, name, &result_.stages, f);
  }

  absl::Status Build() {
    BoundingBox box;
    LIMN_RETURN_IF_ERROR(ValidatePositions(context_, input_.positions, &box));
    scale_ = box.diagonal() > 0 ? box.diagonal() : 1;
    LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh mesh, HalfEdgeMesh::Build(context_, input_));
    LIMN_RETURN_IF_ERROR(CheckClosed(mesh));
    mesh_ = std::move(mesh);
    return MoveToOrigin(box);
  }

  // Far from the origin coordinates leave few bits for the shape, and rounding alone moves points
  // by more than a solve's tolerance. The job then runs on points around the origin.
  absl::Status MoveToOrigin(const BoundingBox& box) {
    constexpr double kFar = 64;
    const Vec3 middle = 0.5 * box.min + 0.5 * box.max;
    points_ = input_.positions;
    if (MaxAbs(middle) <= kFar * box.diagonal()) return absl::OkStatus();
    origin_ = middle;
    moved_points_.resize(points_.size());
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, points_.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) moved_points_[v] = input_.positions[v] - middle;
        }));
    points_ = moved_points_;
    return absl::OkStatus();
  }

  absl::Status MoveBack(absl::Span<Vec3> points) const {
    if (!origin_.has_value()) return absl::OkStatus();
    return ParallelFor(context_, points.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) points[i] += *origin_;
    });
  }

  absl::Status SolveControlMesh() {
    const LimitStencil stencil = DooSabinModifiedStencil();
    result_.control_positions.resize(input_.vertex_count());
    const SolveProblem problem = {
        .mesh = *mesh_, .stencil = stencil, .points = points_, .scale = scale_};
    LIMN_ASSIGN_OR_RETURN(result_.solve, Solve(context_, problem, options_.solve,
                                               absl::MakeSpan(result_.control_positions)));
    return absl::OkStatus();
  }

  // From M^1 to M^level; mesh_ ends as T^(level - 1).
  absl::Status Refine() {
    if (options_.level < 2) return absl::OkStatus();
    LIMN_ASSIGN_OR_RETURN(fans_, FindExtraordinaryFans(context_, *mesh_));
    for (std::uint32_t k = 1; k < options_.level; ++k) {
      const HalfEdgeMesh& mesh = *mesh_;
      Buffer<Vec3> refined(4 * mesh.half_edge_count());
      LIMN_RETURN_IF_ERROR(RefineDooSabin(context_, {.mesh = mesh, .fans = fans_, .k = k}, corners_,
                                          absl::MakeSpan(refined)));
      corners_ = std::move(refined);
      LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh split, SplitIntoQuads(context_, mesh));
      mesh_ = std::move(split);
      context_.Report(
          {.stage = "refine", .fraction = static_cast<double>(k) / (options_.level - 1)});
    }
    return absl::OkStatus();
  }

  absl::Status Tessellate() {
    const HalfEdgeMesh& mesh = *mesh_;
    Tessellation& surface = result_.surface;
    surface.level = options_.level;
    const bool given_faces = options_.level == 0;
    const std::size_t vertices =
        mesh.vertex_count() + (given_faces ? 0 : mesh.edge_count() + mesh.face_count());
    surface.positions.resize(vertices);
    if (options_.normals) surface.normals.resize(vertices);
    LIMN_RETURN_IF_ERROR(DooSabinLimit(
        context_, {.mesh = mesh, .fans = fans_, .k = std::max<std::uint32_t>(1, options_.level)},
        corners_,
        {.points = absl::MakeSpan(surface.positions),
         .normals = absl::MakeSpan(surface.normals),
         .vertices_only = given_faces}));
    if (given_faces) {
      surface.face_begin = input_.face_begin;
      surface.face_vertices = input_.corner_vertex;
      return absl::OkStatus();
    }
    surface.arity = 4;
    surface.face_vertices.resize(4 * mesh.half_edge_count());
    return QuadVertices(context_, mesh, absl::MakeSpan(surface.face_vertices));
  }

  const Context& context_;
  const PolygonMesh& input_;
  const InterpolateOptions& options_;
  InterpolateResult result_;
  double scale_ = 1;
  // The points to interpolate: the input's, or those moved by -origin_.
  absl::Span<const Vec3> points_;
  std::optional<Vec3> origin_;
  Buffer<Vec3> moved_points_;
  // T^(k-1) of the current level k.
  std::optional<HalfEdgeMesh> mesh_;
  // Points of M^k.
  Buffer<Vec3> corners_;
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
