// SPDX-License-Identifier: MIT
#include "server/lane.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/byte_text.h"
#include "engine/base/error.h"

namespace limn {

Lane::Place::Place(Place&& other) noexcept
    : lane_(std::exchange(other.lane_, nullptr)), id_(std::exchange(other.id_, 0)) {}

Lane::Place& Lane::Place::operator=(Place&& other) noexcept {
  if (this == &other) return *this;
  Release();
  lane_ = std::exchange(other.lane_, nullptr);
  id_ = std::exchange(other.id_, 0);
  return *this;
}

void Lane::Place::Post(WorkerThreads::Task task) {
  // Held while the task is posted, so that it does not run before its number is noted.
  const std::lock_guard lock(lane_->mutex_);
  Entry& entry = lane_->places_.at(id_);
  entry.task = lane_->threads_.Post(
      [lane = lane_, id = id_, task = std::move(task)] {
        {
          const std::lock_guard started(lane->mutex_);
          const auto at = lane->places_.find(id);
          if (at == lane->places_.end()) return;
          lane->StopWaiting(&at->second);
        }
        task();
      },
      entry.request.client, entry.request.milliseconds);
}

void Lane::Place::StopRequested(Clock::time_point now) {
  if (lane_ == nullptr) return;
  const std::lock_guard lock(lane_->mutex_);
  Entry& entry = lane_->places_.at(id_);
  if (!std::exchange(entry.told, true)) entry.told_at = now;
}

void Lane::Place::Release() {
  Lane* lane = std::exchange(lane_, nullptr);
  if (lane == nullptr) return;
  WorkerThreads::TaskId task = 0;
  {
    const std::lock_guard lock(lane->mutex_);
    const auto at = lane->places_.find(id_);
    lane->StopWaiting(&at->second);
    task = at->second.task;
    --lane->load_.running;
    lane->places_.erase(at);
  }
  if (task != 0) lane->threads_.Remove(task);
}

Lane::Lane(const LaneOptions& options)
    : options_(options),
      delivery_({.count = static_cast<int>(options.workers), .niceness = options.niceness}),
      threads_({.count = static_cast<int>(options.workers),
                .arena = std::make_shared<ThreadArena>(
                    ThreadArena::Options{.threads = options.threads,
                                         .callers = static_cast<int>(options.workers),
                                         .niceness = options.niceness}),
                .niceness = options.niceness,
                .patience = options.patience}) {}

void Lane::StopWaiting(Entry* entry) {
  if (std::exchange(entry->running, true)) return;
  ++load_.running;
  --load_.waiting;
  load_.waiting_bytes -= entry->request.bytes;
  load_.waiting_milliseconds -= entry->request.milliseconds;
}

absl::StatusOr<Lane::Place> Lane::Reserve(const LaneRequest& request) {
  const std::lock_guard lock(mutex_);
  LIMN_RETURN_IF_ERROR(PositionOfNext(request).status());
  places_.emplace(++last_id_, Entry{.request = request});
  ++load_.waiting;
  load_.waiting_bytes += request.bytes;
  load_.waiting_milliseconds += request.milliseconds;
  return Place(this, last_id_);
}

absl::StatusOr<std::uint64_t> Lane::NextPosition(const LaneRequest& request) const {
  const std::lock_guard lock(mutex_);
  return PositionOfNext(request);
}

absl::StatusOr<std::uint64_t> Lane::PositionOfNext(const LaneRequest& request) const {
  const auto busy = [&](const std::string& what, const std::string& limit) {
    return MakeError(absl::StrCat("the server is busy: in lane \"", options_.name, "\" ", what,
                                  " (limit ", limit, ")"),
                     {.reason = Reason::kLimitExceeded,
                      .remedy = "Try again a little later",
                      .limit = limit,
                      .retryable = true});
  };
  const std::uint64_t taken = places_.size();
  if (taken >= options_.workers + options_.queue_length) {
    return busy(
        absl::StrCat("there are ", taken, " jobs, of which ", options_.queue_length, " wait"),
        "queue-length");
  }
  if (taken < options_.workers) return 0;
  const auto fits = [](std::uint64_t held, std::uint64_t more, std::uint64_t limit) {
    return held <= limit && more <= limit - held;
  };
  if (!fits(load_.waiting_bytes, request.bytes, options_.queue_bytes)) {
    return busy(absl::StrCat("jobs of ", ByteText(load_.waiting_bytes), " of memory wait"),
                "queue-bytes");
  }
  if (!fits(load_.waiting_milliseconds, request.milliseconds, options_.queue_milliseconds)) {
    return busy(absl::StrCat("jobs of ", load_.waiting_milliseconds, " milliseconds wait"),
                "queue-milliseconds");
  }
  return taken + 1 - options_.workers;
}

Lane::Load Lane::load() const {
  const std::lock_guard lock(mutex_);
  return load_;
}

std::uint64_t Lane::places_taken() const {
  const std::lock_guard lock(mutex_);
  return places_.size();
}

std::uint64_t Lane::StuckJobs(Clock::time_point since) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t stuck = 0;
  for (const auto& [id, entry] : places_) {
    if (entry.running && entry.told && entry.told_at < since) ++stuck;
  }
  return stuck;
}

bool Lane::StopUntil(Clock::time_point until) {
  const bool computed = threads_.StopUntil(until);
  return delivery_.StopUntil(until) && computed;
}

void Lane::Stop() {
  threads_.Stop();
  delivery_.Stop();
}

}  // namespace limn
