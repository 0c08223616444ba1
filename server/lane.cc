// SPDX-License-Identifier: MIT
#include "server/lane.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {

Lane::Place::Place(Place&& other) noexcept
    : lane_(std::exchange(other.lane_, nullptr)), task_(std::exchange(other.task_, 0)) {}

Lane::Place& Lane::Place::operator=(Place&& other) noexcept {
  if (this == &other) return *this;
  Release();
  lane_ = std::exchange(other.lane_, nullptr);
  task_ = std::exchange(other.task_, 0);
  return *this;
}

void Lane::Place::Post(WorkerThreads::Task task) { task_ = lane_->threads_.Post(std::move(task)); }

void Lane::Place::Release() {
  Lane* lane = std::exchange(lane_, nullptr);
  if (lane == nullptr) return;
  if (task_ != 0) lane->threads_.Remove(std::exchange(task_, 0));
  const std::lock_guard lock(lane->mutex_);
  --lane->taken_;
}

Lane::Lane(const LaneOptions& options)
    : options_(options),
      threads_(static_cast<int>(options.workers), std::make_shared<ThreadArena>(options.threads)) {}

absl::StatusOr<Lane::Place> Lane::Reserve() {
  const std::lock_guard lock(mutex_);
  LIMN_RETURN_IF_ERROR(PositionOfNext().status());
  ++taken_;
  return Place(this);
}

absl::StatusOr<std::uint64_t> Lane::NextPosition() const {
  const std::lock_guard lock(mutex_);
  return PositionOfNext();
}

absl::StatusOr<std::uint64_t> Lane::PositionOfNext() const {
  if (taken_ >= options_.workers + options_.queue_length) {
    return MakeError(
        absl::StrCat("the server is busy: lane \"", options_.name, "\" has ", taken_,
                     " jobs, of which ", options_.queue_length, " wait (limit queue-length)"),
        {.reason = Reason::kLimitExceeded,
         .remedy = "Try again a little later",
         .limit = "queue-length",
         .retryable = true});
  }
  return taken_ < options_.workers ? 0 : taken_ + 1 - options_.workers;
}

std::uint64_t Lane::places_taken() const {
  const std::lock_guard lock(mutex_);
  return taken_;
}

}  // namespace limn
