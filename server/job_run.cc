// SPDX-License-Identifier: MIT
#include "server/job_run.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "server/job_memory.h"

namespace limn {
namespace {

using Milliseconds = std::chrono::duration<double, std::milli>;

}  // namespace

template <class Rpc>
JobRun<Rpc>::JobRun(ServiceCore& core, Caller caller, std::optional<Clock::time_point> deadline)
    : core_(core),
      caller_(std::move(caller)),
      deadline_(deadline),
      request_id_(caller_.request_id),
      phase_start_(Clock::now()) {}

template <class Rpc>
absl::Status JobRun<Rpc>::TakeHeader(const v1::InterpolateHeader& header, v1::Accepted* accepted) {
  LIMN_ASSIGN_OR_RETURN(spec_, Rpc::Spec(header));
  if (spec_.request_id.empty()) spec_.request_id = caller_.request_id;
  request_id_ = spec_.request_id;
  SetCounts(spec_.mesh);
  FitFinestLevel(EngineLimits(core_.limits), &spec_);
  LIMN_ASSIGN_OR_RETURN(ticket_, core_.admission.Admit(spec_, caller_.client));
  upload_.emplace(spec_.mesh.byte_count());
  phase_start_ = Clock::now();

  accepted->set_request_id(request_id_);
  accepted->set_server_version(LIMN_VERSION);
  accepted->set_estimated_bytes(ticket_.estimate);
  accepted->set_queue_position(static_cast<std::uint32_t>(ticket_.position));
  accepted->set_lane(ticket_.lane->name());
  accepted->set_estimated_milliseconds(ticket_.request.milliseconds);
  return absl::OkStatus();
}

template <class Rpc>
absl::Status JobRun<Rpc>::Enqueue(const std::function<void(const ProgressEvent&)>& progress,
                                  WorkerThreads::Task task) {
  LIMN_RETURN_IF_ERROR(core_.admission.Enqueue(&ticket_));
  Context context(EngineLimits(core_.limits));
  if (deadline_.has_value()) context.set_deadline(*deadline_);
  stop_ = context;
  context.set_progress(progress);
  job_ = std::make_unique<typename Rpc::Job>(spec_, std::move(context));
  const Clock::time_point now = Clock::now();
  job_->AddStage("receive", Milliseconds(now - phase_start_).count());
  phase_start_ = now;
  ticket_.place.Post(std::move(task));
  return absl::OkStatus();
}

template <class Rpc>
void JobRun<Rpc>::BeginRun() {
  const Milliseconds waited = Clock::now() - phase_start_;
  job_->AddStage("queue", waited.count());
  core_.metrics.ObserveQueueWait(ticket_.lane->name(), waited.count() / 1000);
}

// Nobody else touches the job, the upload or the ticket's memory while it runs. The memory set
// aside grows with what is known: a Draco mesh need not have claimed its counts.
template <class Rpc>
absl::Status JobRun<Rpc>::Compute() {
  std::string encoded = upload_->TakeBytes();
  LIMN_ASSIGN_OR_RETURN(const std::uint64_t decoding, EstimateDecodeBytes(spec_, encoded));
  LIMN_RETURN_IF_ERROR(Grow(decoding));
  if (absl::Status status = job_->Decode(std::move(encoded)); !status.ok()) {
    core_.metrics.CountDecodeReject(status);
    return status;
  }
  LIMN_RETURN_IF_ERROR(Grow(EstimateJobBytes(job_->spec())));
  SetCounts(job_->spec().mesh);
  LIMN_RETURN_IF_ERROR(job_->Run());
  // A level may have been chosen that is coarser than the finest one that was set aside for.
  ticket_.memory.Shrink(EstimateJobBytes(job_->spec()));
  return absl::OkStatus();
}

template <class Rpc>
absl::Status JobRun<Rpc>::Grow(std::uint64_t bytes) {
  absl::Status status = core_.admission.Grow(bytes, &ticket_.memory);
  core_.metrics.CountAdmissionReject(status);
  return status;
}

template <class Rpc>
absl::StatusOr<bool> JobRun<Rpc>::NextMessage(Response* message) {
  return Guarded("encoding the answer", Reason::kInternal,
                 [&]() -> absl::StatusOr<bool> { return job_->NextMessage(message); });
}

template <class Rpc>
void JobRun<Rpc>::Stop(bool running, Clock::time_point now) {
  stop_.Cancel();
  ticket_.upload.Release();
  if (running) {
    ticket_.place.StopRequested(now);
  } else {
    ticket_.place.Release();
  }
}

template <class Rpc>
absl::Status JobRun<Rpc>::CheckQueueTime(Clock::time_point now) const {
  const std::uint64_t queue = core_.limits.queue_seconds;
  if (now - phase_start_ < std::chrono::seconds(queue)) return absl::OkStatus();
  absl::Status status = MakeError(absl::StrCat("the server is busy: the job has waited for ", queue,
                                               " seconds (limit queue-seconds)"),
                                  {.reason = Reason::kLimitExceeded,
                                   .remedy = "Try again a little later",
                                   .limit = "queue-seconds",
                                   .retryable = true});
  core_.metrics.CountAdmissionReject(status);
  return status;
}

template <class Rpc>
void JobRun<Rpc>::SetCounts(const v1::MeshHeader& mesh) {
  const std::lock_guard lock(counts_mutex_);
  vertices_ = mesh.vertex_count();
  faces_ = mesh.face_count();
}

template <class Rpc>
void JobRun<Rpc>::LogEnd(const absl::Status& status, bool at_rest,
                         const std::string& job_id) const {
  core_.metrics.CountRequest(Rpc::kName, status);
  at_rest = at_rest && job_ != nullptr;
  if (status.ok()) {
    for (const StageTime& stage : job_->stages()) {
      core_.metrics.ObserveStage(stage.stage, stage.milliseconds / 1000);
    }
  }
  LogLine line("job");
  line.Add("request_id", request_id_).Add("method", Rpc::kName).Add("peer", caller_.peer);
  line.Add("client", caller_.client);
  if (!job_id.empty()) line.Add("job_id", job_id);
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
  {
    const std::lock_guard lock(counts_mutex_);
    line.Add("vertices", vertices_).Add("faces", faces_);
  }
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

template class JobRun<InterpolateRpc>;
template class JobRun<EvaluateRpc>;
template class JobRun<BatchJobRpc>;

}  // namespace limn
