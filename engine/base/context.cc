// SPDX-License-Identifier: MIT
#include "engine/base/context.h"

#include "engine/base/error.h"

namespace limn {

Context::Context() : Context(Limits{}) {}

Context::Context(const Limits& limits) : shared_(std::make_shared<Shared>()), limits_(limits) {}

void Context::set_deadline(Clock::time_point deadline) { deadline_ = deadline; }

void Context::Cancel() const { shared_->cancelled.store(true, std::memory_order_relaxed); }

bool Context::stop_requested() const {
  if (shared_->cancelled.load(std::memory_order_relaxed)) return true;
  return deadline_.has_value() && Clock::now() >= *deadline_;
}

absl::Status Context::Check() const {
  if (shared_->cancelled.load(std::memory_order_relaxed)) {
    return MakeError("the job was cancelled", {.reason = Reason::kCancelled});
  }
  if (deadline_.has_value() && Clock::now() >= *deadline_) {
    return MakeError("the job's deadline has passed", {.reason = Reason::kDeadlineExceeded});
  }
  return absl::OkStatus();
}

}  // namespace limn
