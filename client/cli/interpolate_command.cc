// SPDX-License-Identifier: MIT
// `limn interpolate`: a mesh file in, its limit surface and control mesh out.
#include <memory>

#include <CLI/App.hpp>

#include "client/cli/commands.h"
#include "client/cli/constraints_file.h"
#include "client/cli/job_options.h"
#include "client/cli/surface_command.h"

namespace limn::cli {

void AddInterpolateCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "interpolate", "Find the smooth surface that passes through the vertices of a mesh");
  const auto flags = std::make_shared<SurfaceFlags>();
  AddInputAndOutputFlags(*command, flags.get());
  AddConstraintsFlag(*command, &flags->constraints);
  AddSolveFlags(*command, &flags->job);
  AddCommonFlags(*command, flags.get());
  command->callback([flags, status] { *status = RunSurfaceCommand(*flags); });
}

}  // namespace limn::cli
