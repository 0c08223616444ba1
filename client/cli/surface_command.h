// SPDX-License-Identifier: MIT
// What the subcommands share that make a surface of a mesh file: `limn interpolate` and
// `limn features`.
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "client/cli/connection.h"
#include "client/cli/exit_status.h"
#include "client/cli/job_options.h"
#include "client/cli/outputs.h"

namespace limn::cli {

struct SurfaceFlags {
  std::string input;
  // A file of limn.v1.Constraints, or one of limn.v1.FeatureValues alone; empty for none.
  std::string constraints;
  std::string features;
  OutputPaths outputs;
  JobOptions job;
  ConnectionOptions connection;
  bool quiet = false;
};

// Adds IN and the flags of what is written; those of the tessellation, of the connection and
// --quiet.
void AddInputAndOutputFlags(CLI::App& app, SurfaceFlags* flags);
void AddCommonFlags(CLI::App& app, SurfaceFlags* flags);

// Reads, has it made, writes. Prints the summary, or what went wrong.
ExitStatus RunSurfaceCommand(const SurfaceFlags& flags);

}  // namespace limn::cli
