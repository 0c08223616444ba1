// SPDX-License-Identifier: MIT
#include "server/batch_reactor.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/status.h"
#include "server/deadline.h"
#include "server/stream_errors.h"

namespace limn {
namespace {

// Messages that are encoded, or being so, while one is written.
constexpr std::size_t kMostEncoded = 4;

using Seconds = std::chrono::duration<double>;

// Whether the message is a part of a job's answer, not one about a job.
bool IsAnswer(const v1::BatchResponse& message) {
  return message.has_response() && !message.response().has_accepted() &&
         !message.response().has_progress();
}

std::int64_t Inflight(const v1::BatchResponse& message) {
  return IsAnswer(message) ? static_cast<std::int64_t>(message.ByteSizeLong()) : 0;
}

}  // namespace

BatchReactor* BatchReactor::Create(ServiceCore& core, KeptJobs& kept,
                                   grpc::CallbackServerContext* context) {
  auto* reactor = new BatchReactor(core, kept, context);
  reactor->self_.reset(reactor);
  reactor->Start();
  return reactor;
}

BatchReactor::BatchReactor(ServiceCore& core, KeptJobs& kept, grpc::CallbackServerContext* context)
    : core_(core),
      kept_(kept),
      context_(context),
      deadline_(DeadlineOf(context->raw_deadline())),
      caller_(IdentifyCaller(*context, core.tokens.get())),
      start_(Clock::now()),
      watch_(core.limits, start_) {}

void BatchReactor::Start() {
  const Lock lock(mutex_);
  // First registered, then looked: a drain that begins now either finds it or is seen by it.
  core_.streams.Add(self_);
  if (!caller_.authorized.ok()) {
    End(caller_.authorized);
  } else if (core_.draining.load()) {
    End(ServerIsStopping());
  }
  Advance();
  TryWrite();
}

void BatchReactor::OnReadDone(bool ok) {
  const Lock lock(mutex_);
  reading_ = false;
  if (end_.has_value()) {
    // A client that sends everything before it reads must get that far, or the write that is under
    // way would never end.
    if (ok && !finished_) {
      reading_ = true;
      StartRead(&request_);
    }
    return;
  }
  if (!ok && context_->IsCancelled()) {
    End(CallIsOver(deadline_));
  } else if (!ok) {
    EndOfRequests();
  } else {
    const absl::Status status =
        Guarded("taking a message", Reason::kInternal, [this] { return TakeMessage(); });
    if (!status.ok()) End(status);
  }
  Advance();
  PumpEncoders();
  TryWrite();
}

void BatchReactor::AddJob(const JobPointer& job) {
  jobs_[job->id()] = {.job = job};
  job->Attach(weak_from_this());
}

void BatchReactor::JobReady(const JobPointer& job) {
  const Lock lock(mutex_);
  if (end_.has_value()) return;
  Ready(job);
  // It may have given its place back.
  try_again_ = true;
  Advance();
  PumpEncoders();
  TryWrite();
}

// Told once or more often, or too late.
void BatchReactor::Ready(const JobPointer& job) {
  const auto found = jobs_.find(job->id());
  if (found == jobs_.end() || found->second.job != job || found->second.queued) return;
  if (const absl::Status status = job->error(); !status.ok()) return Fail(job, status);
  found->second.queued = true;
  ready_.push_back(job);
}

// For one of its jobs, which has failed, and for one that was not admitted.
void BatchReactor::Fail(const JobPointer& job, const absl::Status& status) {
  (void)job->Stop(status);
  if (!job->digest().empty()) kept_.Forget(*job);
  SendError(job->id(), job->request_id(), status);
  jobs_.erase(job->id());
  try_again_ = true;
  Drop(job);
}

void BatchReactor::SendError(const std::string& id, const std::string& request_id,
                             const absl::Status& status) {
  ++failed_;
  auto message = std::make_unique<v1::BatchResponse>();
  message->set_job_id(id);
  *message->mutable_error() = wire::ToRichStatus(status, request_id);
  outbox_.push_back(std::move(message));
}

void BatchReactor::SendAccepted(const std::string& id, const v1::Accepted& accepted) {
  auto message = std::make_unique<v1::BatchResponse>();
  message->set_job_id(id);
  *message->mutable_response()->mutable_accepted() = accepted;
  outbox_.push_back(std::move(message));
}

// Giving back a large result takes long, so another thread does it.
void BatchReactor::Drop(JobPointer job) {
  core_.lanes.batch.delivery().Post([job = std::move(job)] {});
}

void BatchReactor::PumpEncoders() {
  while (!end_.has_value() && !ready_.empty() && outbox_.size() + encoding_ < kMostEncoded) {
    const JobPointer job = std::move(ready_.front());
    ready_.pop_front();
    const auto found = jobs_.find(job->id());
    if (found == jobs_.end() || found->second.job != job) continue;
    if (!job->BeginEncode(this)) {
      found->second.queued = false;
      continue;
    }
    ++encoding_;
    job->delivery().Post([self = shared_from_this(), job] { self->Encode(job); });
  }
}

void BatchReactor::Encode(const JobPointer& job) {
  auto message = std::make_unique<v1::BatchResponse>();
  message->set_job_id(job->id());
  const absl::Status status = job->Encode(message->mutable_response());

  const Lock lock(mutex_);
  --encoding_;
  if (end_.has_value()) return;
  if (const auto found = jobs_.find(job->id()); found != jobs_.end() && found->second.job == job) {
    found->second.queued = false;
    if (status.ok()) {
      const bool last = message->response().has_summary();
      core_.metrics.AddInflight(Inflight(*message));
      outbox_.push_back(std::move(message));
      // Before the client can have seen it.
      last ? Answered(job) : Ready(job);
    } else {
      Fail(job, status);
    }
  }
  Advance();
  PumpEncoders();
  TryWrite();
}

void BatchReactor::Answered(const JobPointer& job) {
  const Clock::time_point now = Clock::now();
  ++succeeded_;
  watch_.Touch(now);
  try_again_ = true;
  jobs_.erase(job->id());
  if (job->digest().empty()) return Drop(job);
  answered_.push_back({job, now});
  if (answered_.size() > core_.limits.batch_window) Acknowledge(answered_.front().job->id());
}

void BatchReactor::TryWrite() {
  if (writing_ != nullptr || finished_) return;
  const bool all_answered = input_ended_ && waiting_ == Waiting::kNothing &&
                            !deferred_.has_value() && jobs_.empty() && encoding_ == 0;
  if (!end_.has_value() && outbox_.empty() && all_answered && !TotalsChanged()) {
    End(absl::OkStatus());
  }
  if (end_.has_value()) {
    finished_ = true;
    watch_.BeginWrite(Clock::now(), false);
    context_->AddTrailingMetadata(kRequestIdKey, caller_.request_id);
    Finish(wire::ToGrpcStatus(*end_, caller_.request_id));
  } else if (!outbox_.empty()) {
    std::unique_ptr<v1::BatchResponse> message = std::move(outbox_.front());
    outbox_.pop_front();
    Write(std::move(message));
  } else if (TotalsChanged() && (progress_round_ || all_answered)) {
    WriteTotals();
  } else {
    (void)WriteProgress();
  }
}

bool BatchReactor::WriteProgress() {
  if (!progress_round_) return false;
  for (auto at = jobs_.upper_bound(progress_after_); at != jobs_.end(); ++at) {
    std::optional<v1::Progress> progress = at->second.job->TakeProgress();
    if (!progress.has_value()) continue;
    progress_after_ = at->first;
    auto message = std::make_unique<v1::BatchResponse>();
    message->set_job_id(at->first);
    *message->mutable_response()->mutable_progress() = *std::move(progress);
    Write(std::move(message));
    return true;
  }
  progress_round_ = false;
  return false;
}

void BatchReactor::WriteTotals() {
  told_ = received_ + succeeded_ + failed_;
  auto message = std::make_unique<v1::BatchResponse>();
  v1::BatchProgress* totals = message->mutable_progress();
  totals->set_received(received_);
  totals->set_succeeded(succeeded_);
  totals->set_failed(failed_);
  Write(std::move(message));
}

void BatchReactor::Write(std::unique_ptr<v1::BatchResponse> message) {
  write_start_ = Clock::now();
  watch_.BeginWrite(write_start_, IsAnswer(*message));
  writing_ = std::move(message);
  if (!std::exchange(named_, true)) context_->AddInitialMetadata(kRequestIdKey, caller_.request_id);
  StartWrite(writing_.get());
}

void BatchReactor::OnWriteDone(bool ok) {
  const Lock lock(mutex_);
  const Clock::time_point now = Clock::now();
  watch_.EndWrite(now, writing_->ByteSizeLong());
  core_.metrics.AddStall(Seconds(now - write_start_).count());
  core_.metrics.AddInflight(-Inflight(*writing_));
  writing_.reset();
  if (!ok) End(CallIsOver(deadline_));
  Advance();
  PumpEncoders();
  TryWrite();
}

void BatchReactor::OnCancel() {
  const Lock lock(mutex_);
  End(CallIsOver(deadline_));
  TryWrite();
}

void BatchReactor::Stop(const absl::Status& status) {
  const Lock lock(mutex_);
  End(status);
  TryWrite();
}

// The first reason to end counts. Jobs with a digest go on without the stream.
void BatchReactor::End(const absl::Status& status) {
  if (end_.has_value()) return;
  end_ = status;
  const Clock::time_point now = Clock::now();
  const absl::Status why = status.ok() ? CallIsOver(deadline_) : status;
  const bool keep = !core_.draining.load();
  const auto let_go = [&](const JobPointer& job) {
    const bool goes_on = job->Detach();
    if (keep && goes_on && !job->digest().empty()) return kept_.Keep(job, now);
    (void)job->Stop(why);
    if (!job->digest().empty()) kept_.Forget(*job);
    Drop(job);
  };
  for (const auto& [id, entry] : jobs_) let_go(entry.job);
  for (const AnsweredJob& entry : answered_) let_go(entry.job);
  if (admitting_ != nullptr) let_go(std::exchange(admitting_, nullptr));
  uploading_ = nullptr;
  jobs_.clear();
  answered_.clear();
  ready_.clear();
  deferred_.reset();
  for (const auto& message : outbox_) core_.metrics.AddInflight(-Inflight(*message));
  outbox_.clear();
  // Whoever sends everything before it reads has to get that far.
  if (!reading_ && !finished_ && !input_ended_) {
    reading_ = true;
    StartRead(&request_);
  }
}

void BatchReactor::CheckStall(Clock::time_point now) {
  const Lock lock(mutex_);
  if (done_) return;
  while (!answered_.empty() &&
         now - answered_.front().since >= std::chrono::seconds(core_.limits.resume_seconds)) {
    Acknowledge(answered_.front().job->id());
  }
  const bool writing = writing_ != nullptr || finished_;
  const bool reading = reading_ && !end_.has_value() && waiting_ == Waiting::kNothing;
  const bool upload = reading && uploading_ != nullptr;
  // An orderly end would not get through to a reader that takes nothing.
  absl::Status status = watch_.Check(now, {.for_reader = writing});
  if (!status.ok() && writing) context_->TryCancel();
  if (status.ok() && !end_.has_value()) {
    status = watch_.Check(
        now, {.for_message = upload || (reading && jobs_.empty()), .for_upload = upload});
  }
  if (status.ok() && !end_.has_value()) status = CheckTimes(now);
  if (!status.ok()) End(status);
  progress_round_ = true;
  progress_after_.clear();
  try_again_ = true;
  Advance();
  PumpEncoders();
  TryWrite();
}

absl::Status BatchReactor::CheckTimes(Clock::time_point now) const {
  const std::uint64_t stream = core_.limits.stream_seconds;
  if (stream > 0 && now - start_ >= std::chrono::seconds(stream)) return StreamTookTooLong(stream);
  // Nothing new is taken, and what was taken has been answered.
  if (core_.draining.load() && jobs_.empty() && outbox_.empty() && !input_ended_) {
    return ServerIsStopping();
  }
  return absl::OkStatus();
}

void BatchReactor::OnDone() {
  {
    const Lock lock(mutex_);
    done_ = true;
    const absl::Status status = end_.value_or(absl::UnknownError("ended without a reason"));
    core_.metrics.CountRequest("Batch", status);
    LogLine line("batch");
    line.Add("request_id", caller_.request_id).Add("peer", caller_.peer);
    line.Add("client", caller_.client);
    line.Add("code", absl::StatusCodeToString(status.code()));
    if (!status.ok()) line.Add("message", std::string(status.message()));
    line.Add("received", received_).Add("succeeded", succeeded_).Add("failed", failed_);
    core_.log->Info(line);
  }
  core_.streams.Remove(this);
  core_.lanes.batch.delivery().Post([self = std::move(self_)] {});
}

}  // namespace limn
