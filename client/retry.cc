// SPDX-License-Identifier: MIT
#include "client/retry.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>
#include <thread>
#include <utility>

#include "engine/base/error.h"

namespace limn {
namespace {

constexpr double kFirstPause = 0.1;
constexpr double kGrowth = 3;
constexpr double kLongestPause = 3;
// Clients that lost the same server do not come back all at once.
constexpr double kJitter = 0.2;
// How long a wish to stop may go unheard.
constexpr double kTick = 0.05;
// A deadline of 0 would be none.
constexpr double kShortestDeadline = 1e-3;

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

double Jittered(double seconds) {
  thread_local std::minstd_rand random{std::random_device{}()};
  return seconds * std::uniform_real_distribution<double>(1 - kJitter, 1 + kJitter)(random);
}

}  // namespace

bool ServerWentAway(const absl::Status& status) {
  // Errors of this contract come with their details, a transport's come bare.
  bool bare = true;
  status.ForEachPayload([&bare](absl::string_view, const absl::Cord&) { bare = false; });
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
      return true;
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kCancelled:
      return bare;
    default:
      return false;
  }
}

absl::Status AnswerBrokeOff() {
  return MakeError("the answer broke off",
                   {.reason = Reason::kUnreachable, .field = {}, .remedy = "Try again"});
}

Attempts::Attempts(const ClientOptions& options, std::function<bool()> stop)
    : options_(options), stop_(std::move(stop)), most_(options.attempts), begin_(Now()) {}

double Attempts::SecondsLeft() const {
  if (options_.deadline_seconds <= 0) return std::numeric_limits<double>::infinity();
  return begin_ + options_.deadline_seconds - Now();
}

ClientOptions Attempts::NextOptions() const {
  ClientOptions options = options_;
  if (made_ > 0 && options.deadline_seconds > 0) {
    options.deadline_seconds = std::max(SecondsLeft(), kShortestDeadline);
  }
  return options;
}

bool Attempts::Again(const absl::Status& status) {
  if (!ServerWentAway(status) || last()) return false;
  double pause = kFirstPause;
  for (int i = 0; i < made_; ++i) pause = std::min(pause * kGrowth, kLongestPause);
  pause = Jittered(pause);
  if (pause >= SecondsLeft()) return false;
  ++made_;
  for (const double until = Now() + pause; Now() < until;) {
    if (stop_ && stop_()) return false;
    Sleep(std::clamp(until - Now(), 0.0, kTick));
  }
  return !(stop_ && stop_());
}

}  // namespace limn
