// SPDX-License-Identifier: MIT
#include "client/result_collector.h"

#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "client/retry.h"
#include "engine/base/error.h"
#include "proto/wire/mesh_codec.h"

namespace limn {
namespace {

absl::Status BadAnswer(std::string_view what) {
  return MakeError(std::string("the server's answer makes no sense: ").append(what),
                   {.reason = Reason::kInternal, .remedy = "Use a server of this version"});
}

Limits Unlimited() {
  constexpr auto kMost = std::numeric_limits<std::uint64_t>::max();
  return {.max_vertices = kNoIndex, .max_corners = kNoIndex, .max_bytes = kMost};
}

}  // namespace

ResultCollector::ResultCollector() : surface_(kNoIndex, kNoIndex) {}

absl::Status ResultCollector::Add(v1::InterpolateResponse message) {
  if (message.has_tile()) return surface_.Add(message.tile());
  if (message.has_control_mesh()) return AddControlMesh(message.control_mesh());
  if (message.has_repair()) mapping_.Add(message.repair());
  if (message.has_summary()) {
    summary_ = std::move(*message.mutable_summary());
    mapping_.MoveTo(&*summary_);
  }
  return absl::OkStatus();
}

absl::Status ResultCollector::AddControlMesh(const v1::ControlMeshPart& part) {
  if (part.has_header()) {
    LIMN_RETURN_IF_ERROR(wire::CheckHeader(Unlimited(), part.header()));
    control_header_ = part.header();
    control_.emplace(control_header_.byte_count());
    return absl::OkStatus();
  }
  if (!control_) return BadAnswer("the control mesh has no header");
  return control_->Add(part.chunk());
}

absl::StatusOr<JobResult> ResultCollector::Finish() {
  if (!summary_) return AnswerBrokeOff();
  JobResult result;
  if (control_) {
    if (!control_->complete()) return BadAnswer("the control mesh is not complete");
    const std::string bytes = control_->TakeBytes();
    LIMN_ASSIGN_OR_RETURN(result.control_mesh,
                          wire::DecodeMesh(Context(Unlimited()), control_header_, bytes));
  }
  if (summary_->surface_vertices() > 0) {
    LIMN_ASSIGN_OR_RETURN(result.surface, surface_.Finish());
    result.surface.level = summary_->level();
  }
  // Without connectivity there are no faces to compare.
  const bool faces = result.surface.face_count() > 0;
  if (result.surface.vertex_count() != summary_->surface_vertices() ||
      (faces && result.surface.face_count() != summary_->surface_faces())) {
    return BadAnswer("the surface is not what the summary says");
  }
  result.summary = *std::move(summary_);
  return result;
}

}  // namespace limn
