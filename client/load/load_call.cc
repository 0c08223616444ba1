// SPDX-License-Identifier: MIT
#include "client/load/load_call.h"

#include <grpcpp/grpcpp.h>

#include <optional>

#include "client/client_call.h"
#include "engine/base/error.h"
#include "proto/wire/status.h"

namespace limn::load {
namespace {

// Between two messages that a slow reader takes.
constexpr std::chrono::milliseconds kSlowReader(100);

class LoadCall final
    : public RunningCall,
      public grpc::ClientBidiReactor<v1::InterpolateRequest, v1::InterpolateResponse>,
      public std::enable_shared_from_this<LoadCall> {
 public:
  LoadCall(const CallEnvironment& environment, std::shared_ptr<const PreparedJob> job,
           double intended, std::function<void(Sample)> done)
      : environment_(environment), job_(std::move(job)), done_(std::move(done)) {
    sample_.kind = job_->kind;
    sample_.vertices = job_->vertices;
    sample_.intended = intended;
    sample_.sent = Now();
    PrepareCall(*environment.options, &context_);
  }

  void Start(std::chrono::milliseconds cancel_after) {
    self_ = shared_from_this();
    environment_.stub->async()->Interpolate(&context_, this);
    // Reads of a slow reader begin outside of gRPC's reactions.
    if (slow()) AddHold();
    StartRead(&response_);
    WriteNext();
    StartCall();
    if (job_->kind == JobKind::kCancelled) {
      environment_.timers->At(Timers::Clock::now() + cancel_after,
                              [self = shared_from_this()] { self->Cancel(); });
    }
  }

  void Cancel() override { context_.TryCancel(); }

  void OnWriteDone(bool ok) override {
    if (ok) WriteNext();
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      if (slow()) RemoveHold();
      return;
    }
    sample_.bytes_received += response_.ByteSizeLong();
    if (response_.has_tile()) {
      sample_.last_tile = Now();
      if (sample_.first_tile < 0) sample_.first_tile = sample_.last_tile;
    }
    if (response_.has_summary()) {
      for (const v1::StageTime& stage : response_.summary().stages()) {
        sample_.stages.emplace_back(stage.stage(), stage.milliseconds());
      }
    }
    if (!slow()) {
      StartRead(&response_);
      return;
    }
    environment_.timers->At(Timers::Clock::now() + kSlowReader,
                            [self = shared_from_this()] { self->StartRead(&self->response_); });
  }

  void OnDone(const grpc::Status& status) override {
    sample_.ended = Now();
    const absl::Status error = wire::FromGrpcStatus(status);
    const std::optional<ErrorDetail> detail = GetErrorDetail(error);
    sample_.outcome = detail.has_value() ? std::string(ReasonName(detail->reason))
                                         : absl::StatusCodeToString(error.code());
    sample_.good = Good(error);
    // The context holds the channel, which must not end on a thread of gRPC, as that would wait for
    // itself: the timers' thread lets go of this call, and its owner of the channel after that.
    const std::function<void(Sample)> done = std::move(done_);
    Sample sample = std::move(sample_);
    environment_.timers->At(Timers::Clock::now(), [self = std::move(self_)] {});
    done(std::move(sample));
  }

 private:
  bool slow() const { return job_->kind == JobKind::kSlow; }

  bool Good(const absl::Status& status) const {
    if (job_->kind == JobKind::kHostile) {
      const std::optional<ErrorDetail> detail = GetErrorDetail(status);
      return status.code() == absl::StatusCode::kInvalidArgument ||
             (detail.has_value() && detail->reason == Reason::kLimitExceeded && !detail->retryable);
    }
    return status.ok() ||
           (job_->kind == JobKind::kCancelled && status.code() == absl::StatusCode::kCancelled);
  }

  double Now() const {
    return std::chrono::duration<double>(Timers::Clock::now() - environment_.start).count();
  }

  void WriteNext() {
    if (next_ == job_->messages.size()) {
      StartWritesDone();
      return;
    }
    const v1::InterpolateRequest& message = job_->messages[next_++];
    sample_.bytes_sent += message.ByteSizeLong();
    StartWrite(&message);
  }

  const CallEnvironment environment_;
  const std::shared_ptr<const PreparedJob> job_;
  std::function<void(Sample)> done_;
  grpc::ClientContext context_;
  v1::InterpolateResponse response_;
  std::size_t next_ = 0;
  Sample sample_;
  std::shared_ptr<LoadCall> self_;
};

}  // namespace

std::shared_ptr<RunningCall> StartCall(const CallEnvironment& environment,
                                       std::shared_ptr<const PreparedJob> job, double intended,
                                       std::chrono::milliseconds cancel_after,
                                       std::function<void(Sample)> done) {
  auto call = std::make_shared<LoadCall>(environment, std::move(job), intended, std::move(done));
  call->Start(cancel_after);
  return call;
}

}  // namespace limn::load
