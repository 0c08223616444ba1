// SPDX-License-Identifier: MIT
// What JobReactor does about time, and at the end: stalls, limits of time, counting and logging.
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "server/job_reactor.h"

namespace limn {

template <class Rpc>
void JobReactor<Rpc>::CheckStall(Clock::time_point now) {
  const Lock lock(mutex_);
  if (done_) return;
  // Progress that came too soon after the last one, and was not followed by more.
  TryWrite();
  const bool upload = phase_ == Phase::kUpload && !end_.has_value();
  const bool header = phase_ == Phase::kHeader && !end_.has_value();
  const bool writing = writing_ != nullptr || finished_;
  absl::Status status = watch_.Check(now, {.for_reader = writing && !upload,
                                           .for_message = header || upload || WaitsForInput(),
                                           .for_upload = upload});
  if (status.ok() && !end_.has_value()) status = CheckTimes(now);
  if (status.ok()) return;
  End(status);
  // An orderly end would not get through to a reader that takes nothing.
  if (writing) context_->TryCancel();
}

// What the server's own limits say of the time that the call takes.
template <class Rpc>
absl::Status JobReactor<Rpc>::CheckTimes(Clock::time_point now) const {
  const std::uint64_t stream = core_.limits.stream_seconds;
  if (stream > 0 && now - start_ >= std::chrono::seconds(stream)) {
    return MakeError(absl::StrCat("the call has taken ", stream, " seconds (limit stream-seconds)"),
                     {.reason = Reason::kLimitExceeded, .limit = "stream-seconds"});
  }
  const std::uint64_t queue = core_.limits.queue_seconds;
  if (phase_ == Phase::kQueued && now - phase_start_ >= std::chrono::seconds(queue)) {
    absl::Status status = MakeError(absl::StrCat("the server is busy: the job has waited for ",
                                                 queue, " seconds (limit queue-seconds)"),
                                    {.reason = Reason::kLimitExceeded,
                                     .remedy = "Try again a little later",
                                     .limit = "queue-seconds",
                                     .retryable = true});
    core_.metrics.CountAdmissionReject(status);
    return status;
  }
  return absl::OkStatus();
}

template <class Rpc>
void JobReactor<Rpc>::OnDone() {
  {
    const Lock lock(mutex_);
    done_ = true;
    LogEnd();
  }
  core_.streams.Remove(this);
  // Giving back a large result takes long, so another thread does it.
  delivery().Post([self = std::move(self_)] {});
}

template <class Rpc>
void JobReactor<Rpc>::CountEnd(const absl::Status& status) {
  core_.metrics.CountRequest(Rpc::kName, status);
  if (!status.ok()) return;
  for (const StageTime& stage : job_->stages()) {
    core_.metrics.ObserveStage(stage.stage, stage.milliseconds / 1000);
  }
}

template <class Rpc>
void JobReactor<Rpc>::LogEnd() {
  const absl::Status status = end_.value_or(absl::UnknownError("ended without a reason"));
  CountEnd(status);
  LogLine line("job");
  line.Add("request_id", request_id_).Add("method", Rpc::kName).Add("peer", caller_.peer);
  line.Add("client", caller_.client);
  if (!caller_.trace.trace_id.empty()) {
    line.Add("trace_id", caller_.trace.trace_id).Add("parent_id", caller_.trace.parent_id);
  }
  if (ticket_.lane != nullptr) {
    line.Add("lane", ticket_.lane->name()).Add("estimated_ms", ticket_.request.milliseconds);
  }
  line.Add("code", absl::StatusCodeToString(status.code()));
  if (const std::optional<ErrorDetail> detail = GetErrorDetail(status)) {
    line.Add("reason", ReasonName(detail->reason));
    if (!detail->field.empty()) line.Add("field", detail->field);
    if (!detail->limit.empty()) line.Add("limit", detail->limit);
    line.Add("message", std::string(status.message()));
  }
  line.Add("vertices", spec_.mesh.vertex_count()).Add("faces", spec_.mesh.face_count());
  // A job that still runs, or is still encoded, is not to be looked at.
  const bool at_rest = job_ != nullptr && phase_ != Phase::kRunning && !encoding_;
  line.Add("level", std::uint64_t{at_rest ? job_->level() : spec_.engine.level});
  line.Add("bytes_in", spec_.mesh.byte_count());
  if (at_rest) {
    line.Add("bytes_out", job_->bytes_sent());
    for (const StageTime& stage : job_->stages()) {
      line.Add(std::string(stage.stage) + "_ms", stage.milliseconds);
    }
  }
  core_.log->Info(line);
}

template void JobReactor<InterpolateRpc>::CheckStall(Clock::time_point now);
template void JobReactor<InterpolateRpc>::OnDone();
template void JobReactor<EvaluateRpc>::CheckStall(Clock::time_point now);
template void JobReactor<EvaluateRpc>::OnDone();

}  // namespace limn
