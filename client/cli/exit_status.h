// SPDX-License-Identifier: MIT
// What the command line answers to the shell, and how it says what went wrong.
#pragma once

#include <string_view>

#include "absl/status/status.h"

namespace limn::cli {

enum class ExitStatus : int {
  kOk = 0,
  // The input was refused, or a file could not be read or written.
  kRefused = 1,
  // The command line makes no sense.
  kUsage = 2,
  // The server: not reachable, out of resources or time, not able to, or defective.
  kServer = 3,
  // Ctrl-C, as shells count it: 128 + SIGINT.
  kInterrupted = 130,
};

// The exit status that belongs to an error of a file, of the engine or of the server.
[[nodiscard]] ExitStatus ExitStatusOf(const absl::Status& status);

// Prints "limn: <what>" to stderr. Control characters, which a file or a server may have put into
// the message, are replaced.
void PrintError(std::string_view what);

// Prints the error, if it is one, and returns its exit status.
ExitStatus Fail(const absl::Status& status);

}  // namespace limn::cli
