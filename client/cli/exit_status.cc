// SPDX-License-Identifier: MIT
// What the command line answers to the shell, and how it says what went wrong.
#include "client/cli/exit_status.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "engine/base/error.h"

namespace limn::cli {
namespace {

void Print(const absl::Status& status) { PrintError(std::string(status.message())); }

}  // namespace

void PrintError(std::string_view what) {
  std::string line(what);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  std::fprintf(stderr, "limn: %s\n", line.c_str());
}

ExitStatus FailWithFile(const absl::Status& status) {
  Print(status);
  return ExitStatus::kRefused;
}

ExitStatus FailWithOption(const absl::Status& status) {
  Print(status);
  const auto detail = GetErrorDetail(status);
  const bool usage = detail && detail->reason == Reason::kInvalidOption;
  return usage ? ExitStatus::kUsage : ExitStatus::kRefused;
}

ExitStatus FailWithJob(const absl::Status& status) {
  Print(status);
  const bool refused = status.code() == absl::StatusCode::kInvalidArgument;
  return refused ? ExitStatus::kRefused : ExitStatus::kServer;
}

ExitStatus FailAtServer(const std::string& server, const absl::Status& status) {
  const auto detail = GetErrorDetail(status);
  const bool from_limn = detail && detail->reason == Reason::kShuttingDown;
  if (server.empty() || status.code() != absl::StatusCode::kUnavailable || from_limn) {
    return FailWithJob(status);
  }
  PrintError("no answer from " + server + " (" + std::string(status.message()) +
             "); start limnd there, or leave --server out");
  return ExitStatus::kServer;
}

ExitStatus FailInterrupted() {
  PrintError("interrupted; nothing was written");
  return ExitStatus::kInterrupted;
}

}  // namespace limn::cli
