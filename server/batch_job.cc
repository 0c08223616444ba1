// SPDX-License-Identifier: MIT
#include "server/batch_job.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"

namespace limn {
namespace {

using Seconds = std::chrono::duration<double>;

// The call's name, and the job's.
Caller Named(Caller caller, const std::string& id) {
  absl::StrAppend(&caller.request_id, "/", id);
  return caller;
}

}  // namespace

// Not the call's deadline: a stream that ends by it stops the jobs that end with it.
BatchJob::BatchJob(ServiceCore& core, const Caller& caller, std::string id, std::string digest)
    : core_(core),
      id_(std::move(id)),
      digest_(std::move(digest)),
      client_(caller.client),
      start_(Clock::now()),
      run_(core, Named(caller, id_), std::nullopt) {}

BatchJob::~BatchJob() {
  if (logged_) return;
  if (error_.ok()) {
    error_ = MakeError("the client cancelled or is gone", {.reason = Reason::kCancelled});
  }
  run_.LogEnd(error_, true, id_);
}

absl::Status BatchJob::TakeHeader(const v1::InterpolateHeader& header, v1::Accepted* accepted) {
  return run_.TakeHeader(header, accepted);
}

absl::Status BatchJob::Enqueue() {
  // Held by the task, which may begin at once.
  const Lock lock(mutex_);
  LIMN_RETURN_IF_ERROR(run_.Enqueue([this](const ProgressEvent& event) { Report(event); },
                                    [self = shared_from_this()] { self->Run(); }));
  phase_ = Phase::kQueued;
  return absl::OkStatus();
}

void BatchJob::Run() {
  {
    const Lock lock(mutex_);
    if (phase_ == Phase::kFailed) {
      run_.EndRun();
      return;
    }
    phase_ = Phase::kRunning;
    run_.BeginRun();
  }
  const absl::Status status =
      Guarded("running the job", Reason::kInternal, [&] { return run_.Compute(); });
  {
    const Lock lock(mutex_);
    run_.EndRun();
    progress_.reset();
    if (!error_.ok()) {
      core_.metrics.ObserveCancelToStop(Seconds(Clock::now() - stopped_at_).count());
    } else {
      error_ = status;
    }
    phase_ = error_.ok() ? Phase::kAnswering : Phase::kFailed;
  }
  Tell();
}

void BatchJob::Report(const ProgressEvent& event) {
  const Lock lock(mutex_);
  if (phase_ != Phase::kRunning || !error_.ok()) return;
  progress_ = ProgressOf(event);
}

std::optional<v1::Progress> BatchJob::TakeProgress() {
  const Lock lock(mutex_);
  return std::exchange(progress_, std::nullopt);
}

void BatchJob::Tell() {
  std::shared_ptr<Stream> stream;
  {
    const Lock lock(mutex_);
    stream = stream_.lock();
  }
  if (stream != nullptr) stream->JobReady(shared_from_this());
}

void BatchJob::Attach(const std::weak_ptr<Stream>& stream) {
  const Lock lock(mutex_);
  stream_ = stream;
  if (phase_ != Phase::kAnswering && phase_ != Phase::kAnswered) return;
  phase_ = Phase::kAnswering;
  rewind_ = encoding_;
  if (!encoding_) run_.job()->Rewind();
}

bool BatchJob::Detach() {
  const Lock lock(mutex_);
  stream_.reset();
  return phase_ != Phase::kUpload && phase_ != Phase::kFailed && error_.ok();
}

bool BatchJob::Stop(const absl::Status& why) {
  const Lock lock(mutex_);
  if (!error_.ok() || phase_ == Phase::kAnswered) return false;
  error_ = why;
  stopped_at_ = Clock::now();
  run_.Stop(phase_ == Phase::kRunning, stopped_at_);
  if (phase_ == Phase::kRunning || encoding_) return false;
  phase_ = Phase::kFailed;
  return true;
}

bool BatchJob::BeginEncode(const Stream* stream) {
  const Lock lock(mutex_);
  if (phase_ != Phase::kAnswering || encoding_ || stream_.lock().get() != stream) return false;
  encoding_ = true;
  return true;
}

absl::Status BatchJob::Encode(v1::InterpolateResponse* message) {
  const absl::Status status = run_.NextMessage(message).status();
  bool tell = false;
  {
    const Lock lock(mutex_);
    encoding_ = false;
    if (error_.ok()) error_ = status;
    if (!error_.ok()) {
      phase_ = Phase::kFailed;
    } else if (rewind_) {
      run_.job()->Rewind();
    } else if (message->has_summary()) {
      phase_ = Phase::kAnswered;
      if (!std::exchange(logged_, true)) run_.LogEnd(absl::OkStatus(), true, id_);
    } else if (message->has_tile() && !std::exchange(tile_seen_, true)) {
      core_.metrics.ObserveFirstTile(Seconds(Clock::now() - start_).count());
    }
    tell = std::exchange(rewind_, false);
  }
  // The stream that it was encoded for is not the one that it has now.
  if (tell) Tell();
  return error();
}

absl::Status BatchJob::error() const {
  const Lock lock(mutex_);
  return phase_ == Phase::kFailed ? error_ : absl::OkStatus();
}

}  // namespace limn
