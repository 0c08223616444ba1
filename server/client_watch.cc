// SPDX-License-Identifier: MIT
#include "server/client_watch.h"

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {

void Pace::Resume(Clock::time_point now) {
  if (!running_) since_ = now;
  running_ = true;
}

void Pace::Pause(Clock::time_point now) {
  if (running_) spent_ += now - since_;
  running_ = false;
}

bool Pace::KeepsUp(Clock::time_point now) {
  const Clock::duration spent = spent_ + (running_ ? now - since_ : Clock::duration(0));
  if (spent < window_) return true;
  const double seconds = std::chrono::duration<double>(spent).count();
  const bool enough = static_cast<double>(bytes_) >= seconds * bytes_per_second_;
  since_ = now;
  spent_ = Clock::duration(0);
  bytes_ = 0;
  return enough;
}

ClientWatch::ClientWatch(const ServerLimits& limits, Clock::time_point now)
    : stall_seconds_(limits.stall_seconds),
      bytes_per_second_(limits.min_bytes_per_second),
      last_activity_(now),
      write_start_(now),
      upload_(std::chrono::seconds(stall_seconds_), bytes_per_second_),
      answer_(std::chrono::seconds(stall_seconds_), bytes_per_second_) {}

void ClientWatch::EndUpload(Clock::time_point now) {
  upload_.Pause(now);
  write_start_ = now;
}

void ClientWatch::BeginWrite(Clock::time_point now, bool answer) {
  last_activity_ = now;
  write_start_ = now;
  if (answer) answer_.Resume(now);
}

void ClientWatch::EndWrite(Clock::time_point now, std::uint64_t bytes) {
  last_activity_ = now;
  answer_.Add(bytes);
  answer_.Pause(now);
}

absl::Status ClientWatch::Check(Clock::time_point now, const Waiting& waiting) {
  const auto stalled = [&](const char* what) {
    return MakeError(absl::StrCat(what, " for ", stall_seconds_, " seconds (limit stall-seconds)"),
                     {.reason = Reason::kLimitExceeded, .limit = "stall-seconds"});
  };
  const auto slow = [&](const char* what) {
    return MakeError(absl::StrCat("less than ", bytes_per_second_, " bytes a second ", what, " in ",
                                  stall_seconds_, " seconds (limit min-bytes-per-second)"),
                     {.reason = Reason::kLimitExceeded, .limit = "min-bytes-per-second"});
  };
  const std::chrono::seconds patience(stall_seconds_);
  if (waiting.for_reader && now - write_start_ >= patience) return stalled("no message was taken");
  if (waiting.for_message && now - last_activity_ >= patience) return stalled("no message came");
  if (waiting.for_upload && !upload_.KeepsUp(now)) return slow("of the mesh came");
  if (!answer_.KeepsUp(now)) return slow("of the answer were taken");
  return absl::OkStatus();
}

}  // namespace limn
