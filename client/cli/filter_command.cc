// SPDX-License-Identifier: MIT
// `limn filter`: a mesh in, filtered by the terms of the interpolation series, and its surface out.
#include <memory>

#include <CLI/App.hpp>

#include "client/cli/commands.h"
#include "client/cli/constraints_file.h"
#include "client/cli/job_options.h"
#include "client/cli/surface_command.h"

namespace limn::cli {

void AddFilterCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "filter", "Smooth, sharpen or filter a mesh by the terms of the interpolation series");
  const auto flags = std::make_shared<SurfaceFlags>();
  AddInputAndOutputFlags(*command, flags.get());
  AddConstraintsFlag(*command, &flags->constraints);
  AddFilterFlags(*command, &flags->job);
  AddCommonFlags(*command, flags.get());
  command->callback([flags, status] { *status = RunSurfaceCommand(*flags); });
}

}  // namespace limn::cli
