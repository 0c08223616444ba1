// SPDX-License-Identifier: MIT
// `limn interpolate` and `limn filter`: a mesh file in, a limit surface and its control mesh out.
#include <cerrno>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/App.hpp>

#include "client/cli/commands.h"
#include "client/cli/connection.h"
#include "client/cli/constraints_file.h"
#include "client/cli/interrupt_watcher.h"
#include "client/cli/job_options.h"
#include "client/cli/job_runner.h"
#include "client/cli/outputs.h"
#include "client/cli/progress_bar.h"
#include "client/cli/report.h"
#include "client/cli/staged_files.h"
#include "client/io/mesh_reader.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

struct InterpolateFlags {
  std::string input;
  // Empty for none.
  std::string constraints;
  OutputPaths outputs;
  JobOptions job;
  ConnectionOptions connection;
  bool quiet = false;
};

// The job's header, with the constraints of the file that is named.
absl::StatusOr<v1::InterpolateHeader> MakeHeader(const InterpolateFlags& flags) {
  v1::InterpolateHeader header =
      MakeJobHeader(flags.job, {.surface = !flags.outputs.surfaces.empty(),
                                .control_mesh = !flags.outputs.control_mesh.empty()});
  if (!flags.constraints.empty()) {
    LIMN_ASSIGN_OR_RETURN(*header.mutable_constraints(), ReadConstraintsFile(flags.constraints));
  }
  return header;
}

ExitStatus Run(const InterpolateFlags& flags) {
  absl::Status status = CheckOutputs(flags.outputs, {flags.input, flags.constraints});
  if (!status.ok()) return FailWithOption(status);
  absl::StatusOr<v1::InterpolateHeader> header = MakeHeader(flags);
  if (!header.ok()) return FailWithFile(header.status());

  ProgressBar bar(!flags.quiet);
  JobCanceller canceller;
  const InterruptWatcher watcher([&canceller] { canceller.Cancel(); });
  bar.Show("read", 0);
  absl::StatusOr<PolygonMesh> mesh = ReadMeshFile(flags.input);
  if (canceller.cancelled()) return FailInterrupted();
  bar.Clear();
  if (!mesh.ok()) return FailWithFile(mesh.status());

  absl::StatusOr<Connection> connection = Connection::Open(flags.connection);
  if (!connection.ok()) return FailWithJob(connection.status());
  const absl::StatusOr<JobResult> result =
      RunJob(connection->client(), {*std::move(header), *std::move(mesh)}, &bar, &canceller);
  bar.Clear();
  if (canceller.cancelled()) return FailInterrupted();
  if (!result.ok()) {
    return FailAtServer(flags.connection.server,
                        NameConstraintsFile(result.status(), flags.constraints));
  }

  bar.Show("write", 0);
  StagedFiles files([&canceller] { return canceller.cancelled(); });
  status = WriteOutputs(flags.outputs, *result, &files);
  bar.Clear();
  if (canceller.cancelled()) return FailInterrupted();
  if (!status.ok()) return FailWithFile(status);
  // Before the files appear: after a failure there must be none.
  if (!flags.quiet) {
    std::fputs(SummaryTable(result->summary).c_str(), stdout);
    if (std::fflush(stdout) != 0) {
      return FailWithFile(absl::ErrnoToStatus(errno, "cannot write to standard output"));
    }
  }
  status = files.Commit();
  return status.ok() ? ExitStatus::kOk : FailWithFile(status);
}

// The input, and everything after what is done to it.
void AddFileFlags(CLI::App& command, InterpolateFlags* flags) {
  command.add_option("IN", flags->input, "Mesh, open or closed: .obj, .off, .ply or .stl")
      ->required();
  command
      .add_option("-o,--output", flags->outputs.surfaces,
                  "The tessellated surface: .obj, .off, .ply, .stl or .glb; may be given again "
                  "for further formats")
      ->type_name("OUT")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command
      .add_option("--control-mesh", flags->outputs.control_mesh,
                  "The control mesh, with the input's faces in their order")
      ->type_name("FILE");
  command
      .add_option("--report", flags->outputs.report,
                  "The summary (limn.v1.Summary) as JSON: sizes, sweeps, errors, times")
      ->type_name("FILE.json");
  AddConstraintsFlag(command, &flags->constraints);
}

void AddRunFlags(CLI::App& command, InterpolateFlags* flags) {
  AddTessellationFlags(command, &flags->job);
  AddConnectionFlags(command, &flags->connection);
  command.add_flag("-q,--quiet", flags->quiet, "No table and no progress bar");
}

}  // namespace

void AddInterpolateCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "interpolate", "Find the smooth surface that passes through the vertices of a mesh");
  const auto flags = std::make_shared<InterpolateFlags>();
  AddFileFlags(*command, flags.get());
  AddSolveFlags(*command, &flags->job);
  AddRunFlags(*command, flags.get());
  command->callback([flags, status] { *status = Run(*flags); });
}

void AddFilterCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "filter", "Smooth, sharpen or filter a mesh by the terms of the interpolation series");
  const auto flags = std::make_shared<InterpolateFlags>();
  AddFileFlags(*command, flags.get());
  AddFilterFlags(*command, &flags->job);
  AddRunFlags(*command, flags.get());
  command->callback([flags, status] { *status = Run(*flags); });
}

}  // namespace limn::cli
