// SPDX-License-Identifier: MIT
// The command line `limn`: parses, runs the subcommand, answers with its exit status.
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>

#include "client/cli/commands.h"
#include "client/cli/exit_status.h"
#include "client/cli/usage.h"
#include "engine/base/heap.h"

namespace limn::cli {
namespace {

constexpr const char* kFooter =
    "Exit status: 0 well, perhaps with a warning; 1 the input was refused, or a file cannot be "
    "read\n"
    "or written; 2 the command line makes no sense; 3 the server; 4 jobs of a batch failed, and "
    "the\n"
    "others are done; 5 what `limn load --slo` asks for was not kept; 130 interrupted. After a "
    "failure\n"
    "no output file of the job is left that was not there before.";

// The help that was asked for goes to stdout; a mistake is named on stderr.
ExitStatus AnswerParseError(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    app.exit(error);
    return ExitStatus::kOk;
  }
  const auto chosen = app.get_subcommands();
  const std::string command =
      chosen.empty() ? app.get_name() : app.get_name() + " " + chosen.front()->get_name();
  PrintError(ExplainUsageError(app, error) + "; see '" + command + " --help'");
  return ExitStatus::kUsage;
}

ExitStatus Main(int argc, char** argv) {
  CLI::App app("Interpolating subdivision surfaces: smooth surfaces through every vertex of a mesh",
               "limn");
  app.set_version_flag("--version", "limn " LIMN_VERSION);
  app.require_subcommand(1);
  app.footer(kFooter);
  ExitStatus status = ExitStatus::kOk;
  AddInterpolateCommand(app, &status);
  AddBatchCommand(app, &status);
  AddFilterCommand(app, &status);
  AddFeaturesCommand(app, &status);
  AddEvaluateCommand(app, &status);
  AddGenerateCommand(app, &status);
  AddHealthCommand(app, &status);
  AddInfoCommand(app, &status);
  AddLoadCommand(app, &status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return AnswerParseError(app, error);
  }
  // Output that nobody could take, on a full disk for instance, is no success.
  if (status == ExitStatus::kOk && (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)) {
    PrintError("standard output cannot be written");
    return ExitStatus::kRefused;
  }
  return status;
}

}  // namespace
}  // namespace limn::cli

int main(int argc, char** argv) {
  limn::KeepHeap();
  using limn::cli::ExitStatus;
  try {
    return static_cast<int>(limn::cli::Main(argc, argv));
  } catch (const std::bad_alloc&) {
    limn::cli::PrintError("out of memory; use a smaller mesh or a lower level");
  } catch (const std::exception& error) {
    limn::cli::PrintError(std::string("internal error: ") + error.what());
  }
  return static_cast<int>(ExitStatus::kServer);
}
