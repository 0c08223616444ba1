// SPDX-License-Identifier: MIT
#include "server/job_reactor.h"

#include <random>
#include <utility>

#include "absl/strings/str_format.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/status.h"
#include "server/deadline.h"
#include "server/job_memory.h"

namespace limn {
namespace {

// Encoded messages that wait while one is written.
constexpr std::size_t kMostEncoded = 2;
constexpr std::chrono::milliseconds kProgressInterval(100);
// gRPC's clock, which ends calls at their deadline, and ours are not the same.
constexpr std::chrono::milliseconds kClockSlack(10);

using Milliseconds = std::chrono::duration<double, std::milli>;

std::string MakeRequestId() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return absl::StrFormat("%016x", random());
}

}  // namespace

template <class Rpc>
JobReactor<Rpc>* JobReactor<Rpc>::Create(ServiceCore& core, grpc::CallbackServerContext* context) {
  auto* reactor = new JobReactor(core, context);
  reactor->self_.reset(reactor);
  reactor->Start();
  return reactor;
}

template <class Rpc>
JobReactor<Rpc>::JobReactor(ServiceCore& core, grpc::CallbackServerContext* context)
    : core_(core),
      context_(context),
      deadline_(DeadlineOf(context->raw_deadline())),
      watch_(core.limits, Clock::now()),
      request_id_(MakeRequestId()),
      phase_start_(Clock::now()) {}

template <class Rpc>
void JobReactor<Rpc>::Start() {
  const Lock lock(mutex_);
  // First registered, then looked: a drain that begins now either finds it or is seen by it.
  core_.streams.Add(self_);
  if (core_.draining.load()) {
    End(MakeError("the server is stopping", {.reason = Reason::kShuttingDown,
                                             .remedy = "Try another server, or again later"}));
    return;
  }
  this->StartRead(&request_);
}

// With an input that waits, reading waits too, unless what comes is only dropped.
template <class Rpc>
void JobReactor<Rpc>::ReadMore() {
  if (finished_) return;
  read_paused_ = input_.has_value() && !end_.has_value();
  if (!read_paused_) this->StartRead(&request_);
}

template <class Rpc>
void JobReactor<Rpc>::OnReadDone(bool ok) {
  const Lock lock(mutex_);
  if (end_.has_value()) {
    // A client that sends everything before it reads must get that far, or the write that is under
    // way would never end.
    if (ok) ReadMore();
    return;
  }
  watch_.Touch(Clock::now());
  const absl::Status status = Guarded("taking a message", Reason::kInternal,
                                      [&] { return ok ? TakeMessage() : EndOfRequests(); });
  if (!status.ok()) End(status);
  PumpEncoder();
  if (ok) ReadMore();
}

template <class Rpc>
void JobReactor<Rpc>::RunJob() {
  {
    const Lock lock(mutex_);
    if (end_.has_value()) {
      ticket_.place.Release();
      return;
    }
    phase_ = Phase::kRunning;
    job_->AddStage("queue", Milliseconds(Clock::now() - phase_start_).count());
  }
  const absl::Status status =
      Guarded("running the job", Reason::kInternal, [&] { return Compute(); });

  const Lock lock(mutex_);
  ticket_.place.Release();
  phase_ = Phase::kDelivering;
  watch_.Touch(Clock::now());
  progress_.reset();
  if (end_.has_value()) return;
  if (status.ok()) {
    PumpEncoder();
  } else {
    End(status);
  }
}

// Nobody else touches the job, the upload or the ticket's memory while it runs. The memory set
// aside grows with what is known: a Draco mesh need not have claimed its counts.
template <class Rpc>
absl::Status JobReactor<Rpc>::Compute() {
  Admission::Reservation* const memory = &ticket_.memory;
  std::string encoded = upload_->TakeBytes();
  LIMN_ASSIGN_OR_RETURN(const std::uint64_t decoding, EstimateDecodeBytes(spec_, encoded));
  LIMN_RETURN_IF_ERROR(core_.admission.Grow(decoding, memory));
  LIMN_RETURN_IF_ERROR(job_->Decode(std::move(encoded)));
  LIMN_RETURN_IF_ERROR(core_.admission.Grow(EstimateJobBytes(job_->spec()), memory));
  {
    const Lock lock(mutex_);
    spec_.mesh = job_->spec().mesh;
  }
  LIMN_RETURN_IF_ERROR(job_->Run());
  // A level may have been chosen that is coarser than the finest one that was set aside for.
  memory->Shrink(EstimateJobBytes(job_->spec()));
  return absl::OkStatus();
}

template <class Rpc>
void JobReactor<Rpc>::TakeProgress(const ProgressEvent& event) {
  const Lock lock(mutex_);
  if (phase_ != Phase::kRunning || end_.has_value()) return;
  if (!progress_.has_value()) progress_.emplace();
  progress_->set_stage(std::string(event.stage));
  progress_->set_fraction(event.fraction);
  progress_->set_sweep(event.sweep);
  progress_->set_residual(event.update);
  TryWrite();
}

// Gives the job the input that it needs, as far as it is there. Not while it is encoded.
template <class Rpc>
bool JobReactor<Rpc>::FeedJob() {
  if constexpr (Rpc::kTakesInput) {
    while (job_->NeedsInput()) {
      if (input_.has_value()) {
        job_->AddInput(*std::exchange(input_, std::nullopt));
        if (read_paused_) ReadMore();
      } else if (input_ended_) {
        job_->EndInput();
      } else {
        return false;
      }
    }
  }
  return true;
}

template <class Rpc>
bool JobReactor<Rpc>::WaitsForInput() const {
  if constexpr (Rpc::kTakesInput) {
    return phase_ == Phase::kDelivering && !encoding_ && !end_.has_value() && encoded_.empty() &&
           job_->NeedsInput() && !input_.has_value() && !input_ended_;
  } else {
    return false;
  }
}

template <class Rpc>
void JobReactor<Rpc>::PumpEncoder() {
  if (phase_ != Phase::kDelivering || encoding_ || all_encoded_ || end_.has_value()) return;
  if (encoded_.size() >= kMostEncoded || !FeedJob()) return;
  encoding_ = true;
  core_.delivery.Post([self = this->shared_from_this()] { self->EncodeNext(); });
}

template <class Rpc>
void JobReactor<Rpc>::EncodeNext() {
  // The job is this task's alone while `encoding_` is set.
  auto message = std::make_unique<Response>();
  const absl::StatusOr<bool> more =
      Guarded("encoding the answer", Reason::kInternal,
              [&]() -> absl::StatusOr<bool> { return job_->NextMessage(message.get()); });

  const Lock lock(mutex_);
  encoding_ = false;
  if (end_.has_value()) return;
  if (!more.ok()) {
    End(more.status());
    return;
  }
  if (*more) {
    encoded_.push_back(std::move(message));
  } else {
    all_encoded_ = true;
  }
  TryWrite();
  PumpEncoder();
}

template <class Rpc>
void JobReactor<Rpc>::TryWrite() {
  if (writing_ != nullptr || finished_) return;
  if (!end_.has_value() && all_encoded_ && encoded_.empty()) end_ = absl::OkStatus();
  if (end_.has_value()) {
    finished_ = true;
    watch_.BeginWrite(Clock::now(), false);
    this->Finish(wire::ToGrpcStatus(*end_));
  } else if (!encoded_.empty()) {
    std::unique_ptr<Response> message = std::move(encoded_.front());
    encoded_.pop_front();
    Write(std::move(message));
  } else if (progress_.has_value() && Clock::now() - last_progress_ >= kProgressInterval) {
    WriteProgress();
  }
}

template <class Rpc>
void JobReactor<Rpc>::WriteProgress() {
  auto message = std::make_unique<Response>();
  *message->mutable_progress() = *std::move(progress_);
  progress_.reset();
  last_progress_ = Clock::now();
  Write(std::move(message));
}

template <class Rpc>
void JobReactor<Rpc>::Write(std::unique_ptr<Response> message) {
  watch_.BeginWrite(Clock::now(), phase_ == Phase::kDelivering);
  writing_ = std::move(message);
  this->StartWrite(writing_.get());
}

template <class Rpc>
void JobReactor<Rpc>::OnWriteDone(bool ok) {
  const Lock lock(mutex_);
  watch_.EndWrite(Clock::now(), writing_->ByteSizeLong());
  writing_.reset();
  if (!ok) End(CancelledStatus());
  TryWrite();
  PumpEncoder();
}

template <class Rpc>
void JobReactor<Rpc>::OnCancel() {
  const Lock lock(mutex_);
  End(CancelledStatus());
}

template <class Rpc>
void JobReactor<Rpc>::Stop(const absl::Status& status) {
  const Lock lock(mutex_);
  End(status);
}

template <class Rpc>
absl::Status JobReactor<Rpc>::CancelledStatus() const {
  if (deadline_.has_value() && Clock::now() + kClockSlack >= *deadline_) {
    return MakeError("the job's deadline has passed", {.reason = Reason::kDeadlineExceeded});
  }
  return MakeError("the client cancelled or is gone", {.reason = Reason::kCancelled});
}

// The first reason to end counts. A job that runs gives its place back when it has stopped.
template <class Rpc>
void JobReactor<Rpc>::End(const absl::Status& status) {
  if (end_.has_value()) return;
  end_ = status;
  stop_.Cancel();
  encoded_.clear();
  progress_.reset();
  input_.reset();
  ticket_.upload.Release();
  if (phase_ != Phase::kRunning) ticket_.place.Release();
  TryWrite();
  if (read_paused_) ReadMore();
}

template <class Rpc>
void JobReactor<Rpc>::CheckStall(Clock::time_point now) {
  const Lock lock(mutex_);
  if (done_) return;
  // Progress that came too soon after the last one, and was not followed by more.
  TryWrite();
  const bool upload = phase_ == Phase::kUpload && !end_.has_value();
  const bool header = phase_ == Phase::kHeader && !end_.has_value();
  const bool writing = writing_ != nullptr || finished_;
  const absl::Status status = watch_.Check(now, {.for_reader = writing && !upload,
                                                 .for_message = header || upload || WaitsForInput(),
                                                 .for_upload = upload});
  if (status.ok()) return;
  End(status);
  // An orderly end would not get through to a reader that takes nothing.
  if (writing) context_->TryCancel();
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
  core_.delivery.Post([self = std::move(self_)] {});
}

template <class Rpc>
void JobReactor<Rpc>::LogEnd() {
  const absl::Status status = end_.value_or(absl::UnknownError("ended without a reason"));
  LogLine line("job");
  line.Add("request_id", request_id_).Add("method", Rpc::kName).Add("peer", context_->peer());
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

template class JobReactor<InterpolateRpc>;
template class JobReactor<EvaluateRpc>;

}  // namespace limn
