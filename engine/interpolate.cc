// SPDX-License-Identifier: MIT
#include "engine/interpolate.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/byte_text.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/validate.h"
#include "engine/pipeline/scheme_job.h"

namespace limn {
namespace {

constexpr char kLevelField[] = "surface.level";
constexpr char kToleranceField[] = "surface.chord_tolerance";

// The same job at this level.
InterpolateOptions AtLevel(InterpolateOptions options, std::uint32_t level) {
  options.level = level;
  options.finest = level;
  return options;
}

absl::Status CheckBytes(const Context& context, const PolygonMesh& mesh,
                        const InterpolateOptions& options, std::uint64_t boundary_edges) {
  const std::uint64_t bytes = EstimateBytes(mesh.vertex_count(), mesh.face_count(),
                                            mesh.corner_count(), options, boundary_edges);
  if (bytes <= context.limits().max_bytes) return absl::OkStatus();
  return MakeError(absl::StrCat("the job would need ", ByteText(bytes), ", the limit is ",
                                ByteText(context.limits().max_bytes)),
                   {.reason = Reason::kLimitExceeded,
                    .field = options.chord_tolerance.has_value() ? kToleranceField : kLevelField,
                    .remedy = "Choose a lower level or a larger tolerance, send a smaller mesh or "
                              "raise the limit",
                    .limit = "max-job-bytes"});
}

// Whether this level is allowed, and its numbers and arrays fit. With a chord tolerance
// options.finest is the level.
absl::Status CheckLevel(const Context& context, const PolygonMesh& mesh,
                        const InterpolateOptions& options, std::uint64_t boundary_edges) {
  const bool chosen = options.chord_tolerance.has_value();
  const std::uint32_t level = chosen ? options.finest : options.level;
  if (options.surface && level > context.limits().max_level) {
    return MakeError(absl::StrCat("the level is ", level),
                     {.reason = Reason::kInvalidOption,
                      .field = kLevelField,
                      .remedy = absl::StrCat("It must be at most ", context.limits().max_level)});
  }
  // Half-edges of the finest connectivity: T^(level - 1) for Doo-Sabin, else T^level.
  const int below = options.scheme == Scheme::kDooSabin ? 1 : 0;
  const double half_edges = std::ldexp(static_cast<double>(mesh.corner_count()),
                                       2 * std::max(0, static_cast<int>(level) - below));
  if (options.surface && half_edges >= kNoIndex) {
    return MakeError(absl::StrCat("the refined mesh would have ", half_edges, " half-edges"),
                     {.reason = Reason::kLimitExceeded,
                      .field = chosen ? kToleranceField : kLevelField,
                      .remedy = chosen ? "Choose a larger tolerance" : "Choose a lower level"});
  }
  return CheckBytes(context, mesh, options, boundary_edges);
}

absl::Status CheckOptions(const Context& context, const PolygonMesh& mesh,
                          const InterpolateOptions& options) {
  LIMN_RETURN_IF_ERROR(ValidateSchemeOptions(options));
  LIMN_RETURN_IF_ERROR(ValidateSolveOptions(options.solve));
  // Level 0 is the least that will be needed.
  if (options.chord_tolerance.has_value()) return CheckLevel(context, mesh, AtLevel(options, 0), 0);
  return CheckLevel(context, mesh, options, 0);
}

// The stages of one job, in order.
class Pipeline {
 public:
  Pipeline(const Context& context, const PolygonMesh& input, const InterpolateOptions& options)
      : context_(context),
        input_(input),
        options_(options),
        level_(options.level),
        frame_{.context = context, .input = input, .options = options},
        job_(MakeJob()) {}

  absl::StatusOr<InterpolateResult> Run() {
    LIMN_RETURN_IF_ERROR(CheckOptions(context_, input_, options_));
    LIMN_RETURN_IF_ERROR(frame_.Stage("build", [&] { return Build(); }));
    LIMN_RETURN_IF_ERROR(frame_.Stage("solve", [&] {
      frame_.result.control_positions.resize(input_.vertex_count());
      return job_->FindControlMesh();
    }));
    if (options_.surface || options_.keep_patches) LIMN_RETURN_IF_ERROR(job_->StartSurface());
    if (options_.surface) {
      if (options_.chord_tolerance.has_value()) {
        LIMN_RETURN_IF_ERROR(frame_.Stage("choose_level", [&] { return FindLevel(); }));
      }
      LIMN_RETURN_IF_ERROR(frame_.Stage("refine", [&] { return Refine(); }));
      LIMN_RETURN_IF_ERROR(frame_.Stage("limit", [&] { return job_->Tessellate(); }));
    }
    LIMN_RETURN_IF_ERROR(MoveControlMeshBack());
    return std::move(frame_.result);
  }

 private:
  std::unique_ptr<SchemeJob> MakeJob() {
    if (options_.scheme != Scheme::kDooSabin) return MakePrimalJob(&frame_);
    return options_.constraints.features.has_value() ? MakeFeatureJob(&frame_)
                                                     : MakeDooSabinJob(&frame_);
  }

  absl::Status Build() {
    BoundingBox box;
    LIMN_RETURN_IF_ERROR(ValidatePositions(context_, input_.positions, &box));
    frame_.scale = box.diagonal() > 0 ? box.diagonal() : 1;
    LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh mesh, HalfEdgeMesh::Build(context_, input_));
    LIMN_RETURN_IF_ERROR(ValidateConstraints(context_, options_.constraints, mesh.vertex_count()));
    frame_.plan = VertexPlan(options_.constraints, mesh.vertex_count());
    boundary_edges_ = mesh.boundary_edge_count();
    if (boundary_edges_ > 0 && !options_.chord_tolerance.has_value()) {
      LIMN_RETURN_IF_ERROR(CheckBytes(context_, input_, options_, boundary_edges_));
    }
    LIMN_RETURN_IF_ERROR(MoveToOrigin(box));
    return job_->Start(std::move(mesh));
  }

  // Far from the origin rounding alone moves points by more than a solve's tolerance.
  absl::Status MoveToOrigin(const BoundingBox& box) {
    constexpr double kFar = 64;
    const Vec3 middle = 0.5 * box.min + 0.5 * box.max;
    frame_.points = input_.positions;
    if (MaxAbs(middle) <= kFar * box.diagonal()) return absl::OkStatus();
    frame_.origin = middle;
    frame_.moved = true;
    moved_points_.resize(input_.positions.size());
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, moved_points_.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) moved_points_[v] = input_.positions[v] - middle;
        }));
    frame_.points = moved_points_;
    return absl::OkStatus();
  }

  absl::Status FindLevel() {
    LIMN_ASSIGN_OR_RETURN(const ChordLevel chosen, job_->ChooseLevel(*options_.chord_tolerance));
    level_ = chosen.level;
    frame_.result.chord_bound = chosen.bound;
    return CheckLevel(context_, input_, AtLevel(options_, level_), boundary_edges_);
  }

  absl::Status Refine() {
    for (std::uint32_t k = 0; k < level_; ++k) {
      LIMN_RETURN_IF_ERROR(job_->Refine());
      context_.Report({.stage = "refine", .fraction = static_cast<double>(k + 1) / level_});
    }
    return absl::OkStatus();
  }

  absl::Status MoveControlMeshBack() {
    if (!frame_.moved) return absl::OkStatus();
    Buffer<Vec3>& control = frame_.result.control_positions;
    LIMN_RETURN_IF_ERROR(MoveBack(frame_, absl::MakeSpan(control)));
    const BoundaryControl& boundary = job_->boundary_control();
    for (std::size_t i = 0; i < boundary.vertex.size(); ++i) {
      control[boundary.vertex[i]] = boundary.point[i];
    }
    return absl::OkStatus();
  }

  const Context& context_;
  const PolygonMesh& input_;
  const InterpolateOptions& options_;
  // Asked for, or chosen.
  std::uint32_t level_;
  std::size_t boundary_edges_ = 0;
  Buffer<Vec3> moved_points_;
  JobFrame frame_;
  const std::unique_ptr<SchemeJob> job_;
};

}  // namespace

absl::Status MoveBack(const JobFrame& frame, absl::Span<Vec3> points) {
  return ParallelFor(frame.context, points.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) points[i] += frame.origin;
  });
}

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
