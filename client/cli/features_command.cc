// SPDX-License-Identifier: MIT
// `limn features`: a rough mesh and feature values in, the surface that they shape out.
#include <memory>

#include <CLI/App.hpp>

#include "client/cli/commands.h"
#include "client/cli/surface_command.h"

namespace limn::cli {

void AddFeaturesCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "features",
      "Shape a surface from a rough mesh by feature values: plane faces, sharp and round edges and "
      "vertices (Xu and Kondo)");
  const auto flags = std::make_shared<SurfaceFlags>();
  AddInputAndOutputFlags(*command, flags.get());
  command
      ->add_option("--features", flags->features,
                   "The values, as JSON of limn.v1.FeatureValues; within constraints they may be "
                   "given to interpolate and evaluate too")
      ->type_name("FILE.json")
      ->required();
  AddCommonFlags(*command, flags.get());
  command->callback([flags, status] { *status = RunSurfaceCommand(*flags); });
}

}  // namespace limn::cli
