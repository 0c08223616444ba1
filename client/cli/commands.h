// SPDX-License-Identifier: MIT
// The subcommands of `limn`. Each function adds one; when the command line names it, it runs
// while the line is parsed and leaves its answer in *status.
#pragma once

#include <CLI/App.hpp>

#include "client/cli/exit_status.h"

namespace limn::cli {

void AddInterpolateCommand(CLI::App& app, ExitStatus* status);
void AddBatchCommand(CLI::App& app, ExitStatus* status);
void AddFilterCommand(CLI::App& app, ExitStatus* status);
void AddFeaturesCommand(CLI::App& app, ExitStatus* status);
void AddEvaluateCommand(CLI::App& app, ExitStatus* status);
void AddGenerateCommand(CLI::App& app, ExitStatus* status);
void AddHealthCommand(CLI::App& app, ExitStatus* status);
void AddInfoCommand(CLI::App& app, ExitStatus* status);
void AddLoadCommand(CLI::App& app, ExitStatus* status);

}  // namespace limn::cli
