// SPDX-License-Identifier: MIT
#include "server/job_reactor.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/status.h"
#include "server/deadline.h"
#include "server/stream_errors.h"

namespace limn {
namespace {

// Encoded messages that wait while one is written.
constexpr std::size_t kMostEncoded = 2;
constexpr std::chrono::milliseconds kProgressInterval(100);

using Seconds = std::chrono::duration<double>;

// Whether the message is one of the job's own, not one about it.
template <class Response>
bool IsAnswer(const Response& message) {
  return !message.has_accepted() && !message.has_progress();
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
      caller_(IdentifyCaller(*context, core.tokens.get())),
      watch_(core.limits, Clock::now()),
      run_(core, caller_, deadline_),
      start_(Clock::now()) {}

template <class Rpc>
void JobReactor<Rpc>::Start() {
  const Lock lock(mutex_);
  // First registered, then looked: a drain that begins now either finds it or is seen by it.
  core_.streams.Add(self_);
  if (!caller_.authorized.ok()) {
    End(caller_.authorized);
    return;
  }
  if (core_.draining.load()) {
    End(ServerIsStopping());
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
      run_.EndRun();
      return;
    }
    phase_ = Phase::kRunning;
    run_.BeginRun();
  }
  const absl::Status status =
      Guarded("running the job", Reason::kInternal, [&] { return run_.Compute(); });

  const Lock lock(mutex_);
  run_.EndRun();
  phase_ = Phase::kDelivering;
  watch_.Touch(Clock::now());
  progress_.reset();
  if (end_.has_value()) {
    core_.metrics.ObserveCancelToStop(Seconds(Clock::now() - ended_at_).count());
    return;
  }
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
  progress_ = ProgressOf(event);
  TryWrite();
}

// Gives the job the input that it needs, as far as it is there. Not while it is encoded.
template <class Rpc>
bool JobReactor<Rpc>::FeedJob() {
  if constexpr (Rpc::kTakesInput) {
    while (run_.job()->NeedsInput()) {
      if (input_.has_value()) {
        run_.job()->AddInput(*std::exchange(input_, std::nullopt));
        if (read_paused_) ReadMore();
      } else if (input_ended_) {
        run_.job()->EndInput();
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
           run_.job()->NeedsInput() && !input_.has_value() && !input_ended_;
  } else {
    return false;
  }
}

template <class Rpc>
void JobReactor<Rpc>::PumpEncoder() {
  if (phase_ != Phase::kDelivering || encoding_ || all_encoded_ || end_.has_value()) return;
  if (encoded_.size() >= kMostEncoded || !FeedJob()) return;
  encoding_ = true;
  delivery().Post([self = this->shared_from_this()] { self->EncodeNext(); });
}

template <class Rpc>
void JobReactor<Rpc>::EncodeNext() {
  // The job is this task's alone while `encoding_` is set.
  auto message = std::make_unique<Response>();
  const absl::StatusOr<bool> more = run_.NextMessage(message.get());

  const Lock lock(mutex_);
  encoding_ = false;
  if (end_.has_value()) {
    core_.metrics.ObserveCancelToStop(Seconds(Clock::now() - ended_at_).count());
    return;
  }
  if (!more.ok()) {
    End(more.status());
    return;
  }
  if (*more) {
    core_.metrics.AddInflight(static_cast<std::int64_t>(message->ByteSizeLong()));
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
    context_->AddTrailingMetadata(kRequestIdKey, run_.request_id());
    this->Finish(wire::ToGrpcStatus(*end_, run_.request_id()));
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
  write_start_ = Clock::now();
  if constexpr (requires { writing_->has_tile(); }) {
    if (writing_->has_tile() && !std::exchange(tile_seen_, true)) {
      core_.metrics.ObserveFirstTile(Seconds(write_start_ - start_).count());
    }
  }
  if (!std::exchange(named_, true)) context_->AddInitialMetadata(kRequestIdKey, run_.request_id());
  this->StartWrite(writing_.get());
}

template <class Rpc>
void JobReactor<Rpc>::OnWriteDone(bool ok) {
  const Lock lock(mutex_);
  const Clock::time_point now = Clock::now();
  watch_.EndWrite(now, writing_->ByteSizeLong());
  core_.metrics.AddStall(Seconds(now - write_start_).count());
  if (IsAnswer(*writing_)) {
    core_.metrics.AddInflight(-static_cast<std::int64_t>(writing_->ByteSizeLong()));
  }
  writing_.reset();
  if (!ok) End(CallIsOver(deadline_));
  TryWrite();
  PumpEncoder();
}

template <class Rpc>
void JobReactor<Rpc>::OnCancel() {
  const Lock lock(mutex_);
  End(CallIsOver(deadline_));
}

template <class Rpc>
void JobReactor<Rpc>::Stop(const absl::Status& status) {
  const Lock lock(mutex_);
  End(status);
}

// The first reason to end counts. A job that runs gives its place back when it has stopped.
template <class Rpc>
void JobReactor<Rpc>::End(const absl::Status& status) {
  if (end_.has_value()) return;
  end_ = status;
  ended_at_ = Clock::now();
  run_.Stop(phase_ == Phase::kRunning, ended_at_);
  for (const auto& message : encoded_) {
    if (!IsAnswer(*message)) continue;
    core_.metrics.AddInflight(-static_cast<std::int64_t>(message->ByteSizeLong()));
  }
  encoded_.clear();
  progress_.reset();
  input_.reset();
  TryWrite();
  if (read_paused_) ReadMore();
}

template <class Rpc>
WorkerThreads& JobReactor<Rpc>::delivery() {
  return (run_.lane() != nullptr ? *run_.lane() : core_.lanes.batch).delivery();
}

template class JobReactor<InterpolateRpc>;
template class JobReactor<EvaluateRpc>;

}  // namespace limn
