// SPDX-License-Identifier: MIT
#include "server/evaluate_job.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "engine/base/error.h"

namespace limn {
namespace {

using Clock = std::chrono::steady_clock;

absl::Status Malformed(std::string_view message, std::string_view remedy) {
  return MakeError(message, {.reason = Reason::kMalformedRequest, .remedy = std::string(remedy)});
}

}  // namespace

EvaluateJob::EvaluateJob(const JobSpec& spec, const Context& context)
    : context_(context),
      batch_(std::max<std::size_t>(1, spec.tiles.tile_bytes / wire::kSampleBytes)),
      job_(spec, context) {}

absl::Status EvaluateJob::Run() {
  LIMN_RETURN_IF_ERROR(job_.Run());
  surface_ = job_.TakePatches();
  LIMN_ASSIGN_OR_RETURN(evaluator_, SurfaceEvaluator::Create(context_, *surface_));
  return absl::OkStatus();
}

absl::Status EvaluateJob::CheckInput(const v1::EvaluateRequest& request) {
  if (request.has_job()) {
    return Malformed(request.job().has_header() ? "there is a second header"
                                                : "there is a chunk after the last of the mesh",
                     "Use one stream per job, and send parameters after its mesh");
  }
  if (!request.has_parameters()) {
    return Malformed("there is an empty message among the parameters",
                     "End the stream after the last parameters");
  }
  return wire::CheckParameters(request.parameters());
}

void EvaluateJob::AddInput(v1::EvaluateRequest request) {
  block_ = std::move(*request.mutable_parameters());
  next_ = 0;
}

absl::StatusOr<bool> EvaluateJob::NextMessage(v1::EvaluateResponse* message) {
  if (summary_sent_) return false;
  LIMN_RETURN_IF_ERROR(context_.Check());
  if (next_ < block_size()) {
    const Clock::time_point start = Clock::now();
    LIMN_RETURN_IF_ERROR(NextSamples(message));
    milliseconds_ += std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return true;
  }
  LIMN_RETURN_IF_ERROR(FillSummary(message->mutable_summary()));
  summary_sent_ = true;
  return true;
}

absl::Status EvaluateJob::NextSamples(v1::EvaluateResponse* message) {
  const std::size_t count = std::min(batch_, block_size() - next_);
  const std::vector<SurfaceParameter> parameters = wire::ReadParameters(block_, next_, count);
  samples_.Resize(count);
  LIMN_RETURN_IF_ERROR(evaluator_->Evaluate(context_, parameters, samples_.Spans(), first_));
  wire::EncodeSamples(samples_, first_, message);
  next_ += count;
  first_ += count;
  return absl::OkStatus();
}

// The whole answer of a job that sends neither control mesh nor surface.
absl::Status EvaluateJob::FillSummary(v1::Summary* summary) {
  job_.AddStage("evaluate", milliseconds_);
  v1::InterpolateResponse last;
  LIMN_RETURN_IF_ERROR(job_.NextMessage(&last).status());
  *summary = std::move(*last.mutable_summary());
  summary->set_bytes_sent(bytes_sent());
  return absl::OkStatus();
}

}  // namespace limn
