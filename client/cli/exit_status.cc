// SPDX-License-Identifier: MIT
// What the command line answers to the shell, and how it says what went wrong.
#include "client/cli/exit_status.h"

#include <algorithm>
#include <cstdio>
#include <string>

namespace limn::cli {

ExitStatus ExitStatusOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return ExitStatus::kOk;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
      return ExitStatus::kRefused;
    case absl::StatusCode::kCancelled:
      return ExitStatus::kInterrupted;
    default:
      return ExitStatus::kServer;
  }
}

void PrintError(std::string_view what) {
  std::string line(what);
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  std::fprintf(stderr, "limn: %s\n", line.c_str());
}

ExitStatus Fail(const absl::Status& status) {
  if (!status.ok()) PrintError(std::string(status.message()));
  return ExitStatusOf(status);
}

}  // namespace limn::cli
