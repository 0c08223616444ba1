// SPDX-License-Identifier: MIT
#include "server/job_reactor.h"

#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/status.h"
#include "server/deadline.h"

namespace limn {
namespace {

// Encoded messages that wait while one is written.
constexpr std::size_t kMostEncoded = 2;
constexpr std::chrono::milliseconds kProgressInterval(100);
// gRPC's clock, which ends calls at their deadline, and ours are not the same.
constexpr std::chrono::milliseconds kClockSlack(10);

using Milliseconds = std::chrono::duration<double, std::milli>;

absl::Status Malformed(std::string_view message, std::string_view remedy) {
  return MakeError(message, {.reason = Reason::kMalformedRequest, .remedy = std::string(remedy)});
}

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
      last_activity_(Clock::now()),
      request_id_(MakeRequestId()),
      phase_start_(last_activity_) {}

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
  last_activity_ = Clock::now();
  const absl::Status status = Guarded("taking a message", Reason::kInternal,
                                      [&] { return ok ? TakeMessage() : EndOfRequests(); });
  if (!status.ok()) End(status);
  PumpEncoder();
  if (ok) ReadMore();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeMessage() {
  const v1::InterpolateRequest* const part = Rpc::UploadPart(request_);
  switch (phase_) {
    case Phase::kHeader:
      if (part == nullptr || !part->has_header()) {
        return Malformed("the stream does not begin with a header", "Send the header first");
      }
      return TakeHeader(part->header());
    case Phase::kUpload:
      if (part != nullptr && part->has_header()) {
        return Malformed("there is a second header", "Use one stream per job");
      }
      if (part == nullptr || !part->has_chunk()) {
        return Malformed("there is a message without a chunk among those of the mesh",
                         "Send chunks after the header, to the last of the mesh");
      }
      return TakeChunk(part->chunk());
    case Phase::kQueued:
    case Phase::kRunning:
    case Phase::kDelivering:
      break;
  }
  return TakeInput();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeInput() {
  if constexpr (Rpc::kTakesInput) {
    LIMN_RETURN_IF_ERROR(Rpc::Job::CheckInput(request_));
    input_ = std::move(request_);
    return absl::OkStatus();
  } else {
    return Malformed("there is a message after the last chunk of the mesh",
                     "End the upload after the last chunk");
  }
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeHeader(const v1::InterpolateHeader& header) {
  LIMN_ASSIGN_OR_RETURN(spec_, Rpc::Spec(header));
  if (spec_.request_id.empty()) spec_.request_id = request_id_;
  request_id_ = spec_.request_id;
  LIMN_ASSIGN_OR_RETURN(ticket_, core_.admission.Admit(spec_));
  upload_.emplace(spec_.mesh.byte_count());
  phase_ = Phase::kUpload;
  phase_start_ = Clock::now();

  auto message = std::make_unique<Response>();
  v1::Accepted* accepted = message->mutable_accepted();
  accepted->set_request_id(request_id_);
  accepted->set_server_version(LIMN_VERSION);
  accepted->set_estimated_bytes(ticket_.memory.bytes());
  accepted->set_queue_position(static_cast<std::uint32_t>(ticket_.place.position()));
  encoded_.push_back(std::move(message));
  TryWrite();
  return absl::OkStatus();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::TakeChunk(const v1::MeshChunk& chunk) {
  LIMN_RETURN_IF_ERROR(upload_->Add(chunk));
  if (upload_->complete()) Enqueue();
  return absl::OkStatus();
}

template <class Rpc>
absl::Status JobReactor<Rpc>::EndOfRequests() {
  if (context_->IsCancelled()) return CancelledStatus();
  switch (phase_) {
    case Phase::kHeader:
      return Malformed("the stream ended before the header", "Send a header and the mesh's chunks");
    case Phase::kUpload:
      return Malformed(absl::StrCat("the upload ended after ", upload_->bytes().size(), " of ",
                                    spec_.mesh.byte_count(), " bytes of the mesh"),
                       "Send all chunks and set `last` on the last one");
    case Phase::kQueued:
    case Phase::kRunning:
    case Phase::kDelivering:
      break;
  }
  input_ended_ = true;
  return absl::OkStatus();
}

template <class Rpc>
Context JobReactor<Rpc>::MakeContext() {
  Context context(EngineLimits(core_.limits));
  if (deadline_.has_value()) context.set_deadline(*deadline_);
  stop_ = context;
  context.set_progress([this](const ProgressEvent& event) { TakeProgress(event); });
  return context;
}

template <class Rpc>
void JobReactor<Rpc>::Enqueue() {
  const Clock::time_point now = Clock::now();
  job_ = std::make_unique<typename Rpc::Job>(spec_, MakeContext());
  job_->AddStage("receive", Milliseconds(now - phase_start_).count());
  phase_start_ = now;
  phase_ = Phase::kQueued;
  ticket_.place.Post([self = this->shared_from_this()] { self->RunJob(); });
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
  // Nobody else touches the job or the upload while it runs.
  const absl::Status status = Guarded("running the job", Reason::kInternal,
                                      [&] { return job_->Run(upload_->TakeBytes()); });

  const Lock lock(mutex_);
  ticket_.place.Release();
  phase_ = Phase::kDelivering;
  last_activity_ = Clock::now();
  progress_.reset();
  if (end_.has_value()) return;
  if (status.ok()) {
    PumpEncoder();
  } else {
    End(status);
  }
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
    last_activity_ = Clock::now();
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
  last_activity_ = Clock::now();
  writing_ = std::move(message);
  this->StartWrite(writing_.get());
}

template <class Rpc>
void JobReactor<Rpc>::OnWriteDone(bool ok) {
  const Lock lock(mutex_);
  writing_.reset();
  last_activity_ = Clock::now();
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
  if (phase_ != Phase::kRunning) ticket_.place.Release();
  TryWrite();
  if (read_paused_) ReadMore();
}

template <class Rpc>
void JobReactor<Rpc>::CheckStall(Clock::time_point now) {
  const Lock lock(mutex_);
  const auto limit = std::chrono::seconds(core_.limits.stall_seconds);
  if (done_ || now - last_activity_ < limit) return;
  if (writing_ != nullptr || finished_) {
    // The reader stands still, so that an orderly end would not get through either.
    context_->TryCancel();
  } else if (phase_ == Phase::kHeader || phase_ == Phase::kUpload || WaitsForInput()) {
    End(MakeError(
        absl::StrCat("no message came for ", core_.limits.stall_seconds,
                     " seconds (limit stall-seconds)"),
        {.reason = Reason::kLimitExceeded, .field = "stall-seconds", .limit = "stall-seconds"}));
  }
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
    line.Add("message", std::string(status.message()));
  }
  line.Add("vertices", spec_.mesh.vertex_count()).Add("faces", spec_.mesh.face_count());
  line.Add("level", std::uint64_t{spec_.engine.level}).Add("bytes_in", spec_.mesh.byte_count());
  // A job that still runs, or is still encoded, is not to be looked at.
  if (job_ != nullptr && phase_ != Phase::kRunning && !encoding_) {
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
