// SPDX-License-Identifier: MIT
#include "engine/filter.h"

#include <cmath>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/validate.h"
#include "engine/pipeline/scheme_job.h"

namespace limn {
namespace {

absl::Status Invalid(std::string field, const std::string& message, const std::string& remedy) {
  std::string text = absl::StrCat(field, ": ", message);
  return MakeError(text,
                   {.reason = Reason::kInvalidOption, .field = std::move(field), .remedy = remedy});
}

absl::Status CheckGain(const std::string& field, double gain) {
  if (std::isfinite(gain)) return absl::OkStatus();
  return Invalid(field, absl::StrCat("it is ", gain), "Give a finite number; 1 keeps the term");
}

// The options that say what A is.
InterpolateOptions LimitOptions(const InterpolateOptions& surface) {
  InterpolateOptions options = {
      .scheme = surface.scheme, .rule = surface.rule, .boundary = surface.boundary, .level = 0};
  options.constraints.creases = surface.constraints.creases;
  options.constraints.corners = surface.constraints.corners;
  options.constraints.holes = surface.constraints.holes;
  return options;
}

class FilterRun {
 public:
  FilterRun(const Context& context, const PolygonMesh& mesh, const FilterOptions& filter,
            const InterpolateOptions& options)
      : context_(context),
        mesh_(mesh),
        filter_(filter),
        options_(options),
        frame_{.context = context, .input = mesh, .options = options_},
        job_(options_.scheme == Scheme::kDooSabin ? MakeDooSabinJob(&frame_)
                                                  : MakePrimalJob(&frame_)) {}

  absl::StatusOr<Buffer<Vec3>> Run() {
    BoundingBox box;
    LIMN_RETURN_IF_ERROR(ValidatePositions(context_, mesh_.positions, &box));
    LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh mesh, HalfEdgeMesh::Build(context_, mesh_));
    LIMN_RETURN_IF_ERROR(job_->Start(std::move(mesh)));
    middle_ = 0.5 * box.min + 0.5 * box.max;
    rest_.resize(mesh_.vertex_count());
    sum_.resize(rest_.size());
    limits_.resize(rest_.size());
    LIMN_RETURN_IF_ERROR(ForEach([this](std::size_t v) {
      rest_[v] = mesh_.positions[v] - middle_;
      sum_[v] = {0, 0, 0};
    }));
    for (std::size_t i = 0; i < filter_.gains.size(); ++i) {
      context_.Report(
          {.stage = "filter",
           .fraction = static_cast<double>(i) / static_cast<double>(filter_.gains.size())});
      LIMN_RETURN_IF_ERROR(job_->LimitPoints(rest_, absl::MakeSpan(limits_)));
      const double gain = filter_.gains[i];
      LIMN_RETURN_IF_ERROR(ForEach([this, gain](std::size_t v) {
        sum_[v] += gain * limits_[v];
        rest_[v] -= limits_[v];
      }));
    }
    LIMN_RETURN_IF_ERROR(ForEach(
        [this](std::size_t v) { sum_[v] = middle_ + (sum_[v] + filter_.rest * rest_[v]); }));
    LIMN_RETURN_IF_ERROR(CheckResult());
    return std::move(sum_);
  }

 private:
  template <class F>
  absl::Status ForEach(const F& f) const {
    return ParallelFor(context_, rest_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) f(v);
    });
  }

  // Gains are finite, what they make of points need not be.
  absl::Status CheckResult() const {
    BoundingBox box;
    if (ValidatePositions(context_, sum_, &box).ok()) return absl::OkStatus();
    LIMN_RETURN_IF_ERROR(context_.Check());
    return Invalid("filter.gains", "coordinates of the filtered mesh are not finite or too large",
                   "Give smaller gains");
  }

  const Context& context_;
  const PolygonMesh& mesh_;
  const FilterOptions& filter_;
  const InterpolateOptions& options_;
  JobFrame frame_;
  const std::unique_ptr<SchemeJob> job_;
  Vec3 middle_ = {0, 0, 0};
  // (1 - A)^i M, the sum of the terms so far, and A (1 - A)^i M.
  Buffer<Vec3> rest_;
  Buffer<Vec3> sum_;
  Buffer<Vec3> limits_;
};

}  // namespace

absl::Status ValidateFilter(const FilterOptions& filter, const InterpolateOptions& surface) {
  if (filter.gains.empty()) {
    return Invalid("filter.gains", "there are none", "Give a gain for each term, such as 1");
  }
  if (filter.gains.size() > kMostGains) {
    return Invalid("filter.gains", absl::StrCat("there are ", filter.gains.size()),
                   absl::StrCat("Give at most ", kMostGains));
  }
  for (std::size_t i = 0; i < filter.gains.size(); ++i) {
    LIMN_RETURN_IF_ERROR(CheckGain(absl::StrCat("filter.gains[", i, "]"), filter.gains[i]));
  }
  LIMN_RETURN_IF_ERROR(CheckGain("filter.rest", filter.rest));
  const Constraints& constraints = surface.constraints;
  const std::pair<bool, const char*> others[] = {
      {constraints.interpolate.has_value(), "constraints.interpolate"},
      {!constraints.normals.empty(), "constraints.normals"},
      {!constraints.shape_handles.empty(), "constraints.shape_handles"},
      {!constraints.surface_points.empty(), "constraints.surface_points"},
      {constraints.features.has_value(), "constraints.features"},
  };
  for (const auto& [given, field] : others) {
    if (!given) continue;
    return Invalid(field, "a filtered mesh is not interpolated", "Leave it out");
  }
  if (surface.rule == FirstRule::kBilinear) {
    return Invalid("solve.rule", "filters take the scheme's own first step", "Leave it out");
  }
  return ValidateSchemeOptions(surface);
}

absl::StatusOr<Buffer<Vec3>> Filter(const Context& context, const PolygonMesh& mesh,
                                    const FilterOptions& filter,
                                    const InterpolateOptions& surface) {
  const InterpolateOptions options = LimitOptions(surface);
  LIMN_RETURN_IF_ERROR(ValidateFilter(filter, options));
  const std::uint64_t bytes =
      EstimateFilterBytes(mesh.vertex_count(), mesh.face_count(), mesh.corner_count(), surface);
  if (bytes > context.limits().max_bytes) {
    return MakeError(absl::StrCat("the job would need ", bytes, " bytes, the limit is ",
                                  context.limits().max_bytes),
                     {.reason = Reason::kLimitExceeded,
                      .field = "mesh",
                      .remedy = "Send a smaller mesh or raise the limit",
                      .limit = "max-job-bytes"});
  }
  try {
    return FilterRun(context, mesh, filter, options).Run();
  } catch (const std::bad_alloc&) {
    return MakeError(
        "the system has no more memory for this job",
        {.reason = Reason::kOutOfMemory, .remedy = "Send a smaller mesh or try again later"});
  }
}

}  // namespace limn
