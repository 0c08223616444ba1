// SPDX-License-Identifier: MIT
#include "client/batch_ledger.h"

#include <algorithm>
#include <utility>

#include "engine/base/error.h"

namespace limn {
namespace {

using Kind = BatchLedger::Step::Kind;
using State = OpenJob::State;

v1::BatchRequest CancelRequest(const OpenJob& job) {
  v1::BatchRequest request;
  request.set_job_id(job.id);
  request.mutable_cancel();
  return request;
}

v1::BatchRequest AcknowledgeRequest(const OpenJob& job) {
  v1::BatchRequest request;
  request.set_job_id(job.id);
  request.mutable_acknowledge();
  return request;
}

}  // namespace

bool BatchLedger::RoomLocked() const {
  if (open_.size() >= options_.window) return false;
  return open_.empty() || mesh_bytes_ < options_.mesh_bytes;
}

// *wake: when there may be something else to do.
std::optional<BatchLedger::Step> BatchLedger::FindStep(BatchClock::time_point* wake) {
  if (!streaming_) return Step{.kind = Kind::kStop};
  if (!controls_.empty()) {
    Step step = {.kind = Kind::kControl, .control = std::move(controls_.front())};
    controls_.pop_front();
    return step;
  }
  const BatchClock::time_point now = BatchClock::now();
  for (auto at = waiting_.begin(); at != waiting_.end(); ++at) {
    OpenJob& job = *at->second;
    const bool drop = !job.end.ok();
    if (!drop && job.not_before > now) {
      *wake = std::min(*wake, job.not_before);
      continue;
    }
    job.state = drop ? State::kReporting : State::kSent;
    if (!drop) ++job.tries;
    if (!drop && job.first_sent == BatchClock::time_point{}) job.first_sent = now;
    Step step = {.kind = drop ? Kind::kDrop : Kind::kSend, .job = at->second};
    waiting_.erase(at);
    return step;
  }
  if (!no_more_ && RoomLocked()) return Step{.kind = Kind::kTake};
  if (DoneLocked()) return Step{.kind = Kind::kFinish};
  return std::nullopt;
}

BatchLedger::Step BatchLedger::NextStep() {
  std::unique_lock lock(mutex_);
  for (;;) {
    BatchClock::time_point wake = BatchClock::now() + std::chrono::hours(1);
    if (std::optional<Step> step = FindStep(&wake)) return *std::move(step);
    changed_.wait_until(lock, wake);
  }
}

BatchLedger::UploadStep BatchLedger::NextUploadStep(const OpenJob& job, v1::BatchRequest* control) {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (!streaming_) return UploadStep::kStop;
    if (!controls_.empty()) {
      *control = std::move(controls_.front());
      controls_.pop_front();
      return UploadStep::kControl;
    }
    if (job.state != State::kSent || job.resumed || !job.end.ok()) return UploadStep::kSkip;
    if (!job.known || job.accepted) return UploadStep::kChunk;
    changed_.wait(lock);
  }
}

bool BatchLedger::Add(const std::shared_ptr<OpenJob>& job) {
  const std::lock_guard lock(mutex_);
  if (!open_.emplace(job->id, job).second) return false;
  job->number = next_number_++;
  job->end = end_;
  mesh_bytes_ += job->upload.mesh.bytes.size();
  waiting_.emplace(job->number, job);
  changed_.notify_all();
  return true;
}

void BatchLedger::NoMore() {
  const std::lock_guard lock(mutex_);
  no_more_ = true;
  changed_.notify_all();
}

std::shared_ptr<OpenJob> BatchLedger::FindSent(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(id);
  if (found == open_.end() || found->second->state != State::kSent) return nullptr;
  return found->second;
}

void BatchLedger::Accept(OpenJob* job, bool resumed) {
  const std::lock_guard lock(mutex_);
  job->accepted = true;
  job->resumed = resumed;
  // Not begun anew.
  if (resumed && job->known) --job->tries;
  changed_.notify_all();
}

bool BatchLedger::Retry(OpenJob* job, const absl::Status& status) {
  const std::lock_guard lock(mutex_);
  const auto detail = GetErrorDetail(status);
  const bool may_pass =
      status.code() == absl::StatusCode::kUnavailable || (detail.has_value() && detail->retryable);
  if (!may_pass || !job->end.ok() || ++job->failures >= options_.max_tries) return false;
  job->state = State::kWaiting;
  job->known = job->accepted = job->resumed = false;
  job->not_before = BatchClock::now() + Pause(job->failures);
  waiting_.emplace(job->number, job->shared_from_this());
  // So that the server does not answer the next try with what it keeps of this one.
  controls_.push_back(AcknowledgeRequest(*job));
  changed_.notify_all();
  return true;
}

absl::Status BatchLedger::BeginReport(OpenJob* job) {
  const std::lock_guard lock(mutex_);
  job->state = State::kReporting;
  changed_.notify_all();
  return job->end;
}

void BatchLedger::EndReport(const OpenJob& job, bool acknowledge) {
  const std::lock_guard lock(mutex_);
  if (acknowledge && streaming_) controls_.push_back(AcknowledgeRequest(job));
  mesh_bytes_ -= job.upload.mesh.bytes.size();
  open_.erase(std::string(job.id));
  changed_.notify_all();
}

void BatchLedger::CancelSent(const OpenJob& job) {
  const std::lock_guard lock(mutex_);
  controls_.push_back(CancelRequest(job));
  changed_.notify_all();
}

void BatchLedger::OpenStream() {
  const std::lock_guard lock(mutex_);
  streaming_ = true;
}

void BatchLedger::CloseStream() {
  const std::lock_guard lock(mutex_);
  streaming_ = false;
  changed_.notify_all();
}

std::vector<std::shared_ptr<OpenJob>> BatchLedger::BreakStream(const absl::Status& status) {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<OpenJob>> lost;
  // They were about jobs of that stream.
  controls_.clear();
  for (auto& [id, job] : open_) {
    if (job->state != State::kSent) continue;
    // A server that has outlived a stream was not taken by the job; but an answer that never comes
    // through has to end too.
    const std::uint64_t most = std::uint64_t{options_.max_tries} * (job->resumed ? 10 : 1);
    if (job->accepted && ++job->failures >= most) {
      if (job->end.ok()) job->end = status;
      job->state = State::kReporting;
      lost.push_back(job);
      continue;
    }
    job->state = State::kWaiting;
    job->known = true;
    job->accepted = job->resumed = false;
    job->not_before = {};
    waiting_.emplace(job->number, job);
  }
  changed_.notify_all();
  return lost;
}

void BatchLedger::EndLocked(OpenJob* job, const absl::Status& status) {
  if (!job->end.ok() || job->state == State::kReporting) return;
  job->end = status;
  if (job->state == State::kSent && streaming_) controls_.push_back(CancelRequest(*job));
}

void BatchLedger::EndAll(const absl::Status& status) {
  const std::lock_guard lock(mutex_);
  if (end_.ok()) end_ = status;
  no_more_ = true;
  for (auto& [id, job] : open_) EndLocked(job.get(), status);
  changed_.notify_all();
}

bool BatchLedger::EndOverdue(BatchClock::time_point before, const absl::Status& status) {
  const std::lock_guard lock(mutex_);
  bool stuck = false;
  for (auto& [id, job] : open_) {
    if (job->first_sent == BatchClock::time_point{} || job->first_sent >= before) continue;
    EndLocked(job.get(), status);
    stuck = stuck || (job->state == State::kSent && job->first_sent + kGrace < before);
  }
  changed_.notify_all();
  return stuck;
}

std::vector<std::shared_ptr<OpenJob>> BatchLedger::TakeAll() {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<OpenJob>> all;
  for (auto& [id, job] : open_) {
    if (job->state == State::kReporting) continue;
    job->state = State::kReporting;
    all.push_back(job);
  }
  waiting_.clear();
  no_more_ = true;
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b) { return a->number < b->number; });
  return all;
}

bool BatchLedger::Done() {
  const std::lock_guard lock(mutex_);
  return no_more_ && open_.empty();
}

absl::Status BatchLedger::end() {
  const std::lock_guard lock(mutex_);
  return end_;
}

bool BatchLedger::WaitForEnd(BatchClock::time_point until) {
  std::unique_lock lock(mutex_);
  return changed_.wait_until(lock, until,
                             [this] { return !end_.ok() || (no_more_ && open_.empty()); });
}

BatchClock::duration BatchLedger::Pause(std::uint32_t failures) const {
  constexpr std::uint32_t kMostDoublings = 20;
  const std::uint32_t doublings = std::min(failures > 0 ? failures - 1 : 0, kMostDoublings);
  const auto pause = options_.first_pause * (std::int64_t{1} << doublings);
  return std::min<BatchClock::duration>(pause, options_.longest_pause);
}

}  // namespace limn
