// SPDX-License-Identifier: MIT
// Runs one job to its end, with a progress bar, and lets another thread stop it.
#include "client/cli/job_runner.h"

#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_format.h"
#include "engine/base/error.h"
#include "proto/wire/chunks.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/repair_mapping.h"
#include "proto/wire/tile_codec.h"

namespace limn::cli {
namespace {

absl::Status BadAnswer(std::string_view what) {
  return MakeError(std::string("the server's answer makes no sense: ").append(what),
                   {.reason = Reason::kInternal, .remedy = "Use a server of this version"});
}

// The answer so far.
class Answer {
 public:
  absl::Status Add(v1::InterpolateResponse message) {
    if (message.has_tile()) return surface_.Add(message.tile());
    if (message.has_control_mesh()) return AddControlMesh(message.control_mesh());
    if (message.has_repair()) mapping_.Add(message.repair());
    if (message.has_summary()) {
      summary_ = std::move(*message.mutable_summary());
      mapping_.MoveTo(&*summary_);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<JobResult> Finish() {
    if (!summary_) return BadAnswer("it has no summary");
    JobResult result;
    if (control_) {
      if (!control_->complete()) return BadAnswer("the control mesh is not complete");
      LIMN_ASSIGN_OR_RETURN(
          result.control_mesh,
          wire::DecodeMesh(Context(Unlimited()), control_header_, control_->bytes()));
    }
    if (summary_->surface_vertices() > 0) {
      LIMN_ASSIGN_OR_RETURN(result.surface, surface_.Finish());
      result.surface.level = summary_->level();
    }
    if (result.surface.vertex_count() != summary_->surface_vertices() ||
        result.surface.face_count() != summary_->surface_faces()) {
      return BadAnswer("the surface is not what the summary says");
    }
    result.summary = *std::move(summary_);
    return result;
  }

 private:
  // What a server sends was asked for; its size is the size of the arrays to come.
  static Limits Unlimited() {
    constexpr auto kMost = std::numeric_limits<std::uint64_t>::max();
    return {.max_vertices = kNoIndex, .max_corners = kNoIndex, .max_bytes = kMost};
  }

  absl::Status AddControlMesh(const v1::ControlMeshPart& part) {
    if (part.has_header()) {
      LIMN_RETURN_IF_ERROR(wire::CheckHeader(Unlimited(), part.header()));
      control_header_ = part.header();
      control_.emplace(control_header_.byte_count());
      return absl::OkStatus();
    }
    if (!control_) return BadAnswer("the control mesh has no header");
    return control_->Add(part.chunk());
  }

  wire::MappingCollector mapping_;
  v1::MeshHeader control_header_;
  std::optional<wire::ChunkAssembler> control_;
  wire::SurfaceAssembler surface_{kNoIndex, kNoIndex};
  std::optional<v1::Summary> summary_;
};

void ShowProgress(const v1::Progress& progress, ProgressBar* bar) {
  std::string note;
  if (progress.sweep() > 0) {
    note = absl::StrFormat("sweep %u, largest move %.1e", progress.sweep(), progress.residual());
  }
  bar->Show(progress.stage(), progress.fraction(), note);
}

}  // namespace

void JobCanceller::Cancel() {
  const std::lock_guard lock(mutex_);
  cancelled_ = true;
  if (job_ != nullptr) job_->Cancel();
}

bool JobCanceller::cancelled() const {
  const std::lock_guard lock(mutex_);
  return cancelled_;
}

void JobCanceller::Attach(ClientJob* job) {
  const std::lock_guard lock(mutex_);
  job_ = job;
  if (job_ != nullptr && cancelled_) job_->Cancel();
}

absl::StatusOr<JobResult> RunJob(const Client& client, JobInput input, ProgressBar* bar,
                                 JobCanceller* canceller) {
  bar->Show("send", 0);
  LIMN_ASSIGN_OR_RETURN(ClientJob job, client.Submit(std::move(input.header), input.mesh));
  canceller->Attach(&job);
  const absl::Cleanup detach = [canceller] { canceller->Attach(nullptr); };
  input.mesh = PolygonMesh{};

  Answer answer;
  while (std::optional<v1::InterpolateResponse> message = job.Next()) {
    if (message->has_progress()) {
      ShowProgress(message->progress(), bar);
    } else if (message->has_tile()) {
      bar->Show("receive", 0);
    }
    LIMN_RETURN_IF_ERROR(answer.Add(*std::move(message)));
  }
  LIMN_RETURN_IF_ERROR(job.Finish());
  return answer.Finish();
}

}  // namespace limn::cli
