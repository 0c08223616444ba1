// SPDX-License-Identifier: MIT
// What the command line answers to the shell, and how it says what went wrong.
#include "client/cli/exit_status.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "absl/strings/str_replace.h"
#include "client/cli/flag_names.h"
#include "client/cli/message_file.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

// What limits a job inside this process; see EmbeddedLimits in client/cli/connection.cc.
constexpr const char* kMemory = "(limit: two thirds of the memory there is)";

ExitStatus Fail(const absl::Status& status, const std::string& message, ExitStatus otherwise) {
  PrintError(message);
  const auto detail = GetErrorDetail(status);
  const bool option = detail && detail->reason == Reason::kInvalidOption;
  return option ? ExitStatus::kUsage : otherwise;
}

}  // namespace

void PrintError(std::string_view what) {
  std::string line(what);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  std::fprintf(stderr, "limn: %s\n", line.c_str());
}

ExitStatus FailWithFile(const absl::Status& status) {
  return Fail(status, std::string(status.message()), ExitStatus::kRefused);
}

ExitStatus FailWithJob(const absl::Status& status) {
  if (status.code() == absl::StatusCode::kDeadlineExceeded) {
    PrintError("the job took longer than --deadline allows; allow it more seconds");
    return ExitStatus::kServer;
  }
  const bool refused = status.code() == absl::StatusCode::kInvalidArgument;
  const ExitStatus otherwise = refused ? ExitStatus::kRefused : ExitStatus::kServer;
  const auto detail = GetErrorDetail(status);
  const std::string message = MessageInFlags(status);
  if (detail && !FlagOf(detail->field).empty()) return Fail(status, message, otherwise);
  PrintError(message);
  return otherwise;
}

ExitStatus FailAtServer(const std::string& server, const absl::Status& status) {
  if (server.empty()) {
    const std::string message = absl::StrReplaceAll(
        status.message(),
        {{"(limit max-job-bytes)", kMemory}, {"(limit max-total-bytes)", kMemory}});
    return FailWithJob(WithMessage(status, message));
  }
  const auto detail = GetErrorDetail(status);
  const bool from_limn = detail && detail->reason == Reason::kShuttingDown;
  if (status.code() != absl::StatusCode::kUnavailable || from_limn) {
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
