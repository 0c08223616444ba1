// SPDX-License-Identifier: MIT
// What streams of every kind say when they end.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {

// A message that the contract does not allow at its place.
[[nodiscard]] inline absl::Status MalformedStream(std::string_view message, std::string_view remedy,
                                                  std::string_view field = "") {
  return MakeError(message, {.reason = Reason::kMalformedRequest,
                             .field = std::string(field),
                             .remedy = std::string(remedy)});
}

[[nodiscard]] inline absl::Status ServerIsStopping() {
  return MakeError("the server is stopping", {.reason = Reason::kShuttingDown,
                                              .remedy = "Try another server, or again later"});
}

// Of a call that gRPC says is cancelled: by its client, or by its deadline.
[[nodiscard]] inline absl::Status CallIsOver(
    std::optional<std::chrono::steady_clock::time_point> deadline) {
  // gRPC's clock, which ends calls at their deadline, and ours are not the same.
  constexpr std::chrono::milliseconds kClockSlack(10);
  if (deadline.has_value() && std::chrono::steady_clock::now() + kClockSlack >= *deadline) {
    return MakeError("the job's deadline has passed", {.reason = Reason::kDeadlineExceeded});
  }
  return MakeError("the client cancelled or is gone", {.reason = Reason::kCancelled});
}

[[nodiscard]] inline absl::Status StreamTookTooLong(std::uint64_t seconds) {
  return MakeError(absl::StrCat("the call has taken ", seconds, " seconds (limit stream-seconds)"),
                   {.reason = Reason::kLimitExceeded, .limit = "stream-seconds"});
}

}  // namespace limn
