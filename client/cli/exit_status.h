// SPDX-License-Identifier: MIT
// What the command line answers to the shell, and how it says what went wrong.
#pragma once

#include <string>
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
  // Some jobs of a batch failed, and the others are done.
  kPartial = 4,
  // `limn load`: what --slo asks for was not kept.
  kObjective = 5,
  // Ctrl-C, as shells count it: 128 + SIGINT.
  kInterrupted = 130,
};

// Prints "limn: <what>" to stderr. Control characters, which a file or a server may have put into
// the message, are replaced.
void PrintError(std::string_view what);

// Each prints the error and returns its exit status. `status` is not ok.

// Of a file that was to be read or written, or of an option's value: kUsage for INVALID_OPTION,
// such as an ending that is not known, otherwise kRefused.
ExitStatus FailWithFile(const absl::Status& status);
// Of a job, in words of the command line: a flag's value that makes no sense is kUsage, anything
// else that is wrong with the input kRefused, everything else kServer.
ExitStatus FailWithJob(const absl::Status& status);
// Of a job at a server, empty for the embedded one: as FailWithJob, and with the address where that
// is what is wrong.
ExitStatus FailAtServer(const std::string& server, const absl::Status& status);
// Of Ctrl-C.
ExitStatus FailInterrupted();

}  // namespace limn::cli
