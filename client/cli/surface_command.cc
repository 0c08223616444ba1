// SPDX-License-Identifier: MIT
// A mesh file in, its limit surface and control mesh out.
#include "client/cli/surface_command.h"

#include <cerrno>
#include <cstdio>
#include <utility>

#include "client/cli/constraints_file.h"
#include "client/cli/interrupt_watcher.h"
#include "client/cli/job_runner.h"
#include "client/cli/progress_bar.h"
#include "client/cli/report.h"
#include "client/cli/solve_warning.h"
#include "client/cli/staged_files.h"
#include "client/io/mesh_reader.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

// The job's header, with what is in the files that are named.
absl::StatusOr<v1::InterpolateHeader> MakeHeader(const SurfaceFlags& flags) {
  v1::InterpolateHeader header =
      MakeJobHeader(flags.job, {.surface = !flags.outputs.surfaces.empty(),
                                .control_mesh = !flags.outputs.control_mesh.empty()});
  if (!flags.constraints.empty()) {
    LIMN_ASSIGN_OR_RETURN(*header.mutable_constraints(), ReadConstraintsFile(flags.constraints));
  }
  if (!flags.features.empty()) {
    LIMN_ASSIGN_OR_RETURN(*header.mutable_constraints()->mutable_features(),
                          ReadFeaturesFile(flags.features));
  }
  return header;
}

// The level that a tolerance asks for is of use to a surface only.
absl::Status CheckFlags(const SurfaceFlags& flags) {
  if (flags.job.chord_tolerance && flags.outputs.surfaces.empty()) {
    return MakeError("--chord-tolerance chooses the level of a surface, and none is written",
                     {.reason = Reason::kInvalidOption,
                      .field = "surface.chord_tolerance",
                      .remedy = "Name a file for it with -o"});
  }
  return CheckOutputs(flags.outputs, {flags.input, flags.constraints, flags.features});
}

}  // namespace

ExitStatus RunSurfaceCommand(const SurfaceFlags& flags) {
  absl::Status status = CheckFlags(flags);
  if (!status.ok()) return FailWithFile(status);
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
    return FailAtServer(
        flags.connection.server,
        NameConstraintsFile(result.status(),
                            flags.features.empty() ? flags.constraints : flags.features));
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
  WarnAboutSolve(result->summary.solve(), flags.job);
  status = files.Commit();
  return status.ok() ? ExitStatus::kOk : FailWithFile(status);
}

void AddInputAndOutputFlags(CLI::App& app, SurfaceFlags* flags) {
  app.add_option("IN", flags->input, "Mesh, open or closed: .obj, .off, .ply or .stl")->required();
  app.add_option("-o,--output", flags->outputs.surfaces,
                 "The tessellated surface: .obj, .off, .ply, .stl or .glb; may be given again "
                 "for further formats")
      ->type_name("OUT")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--control-mesh", flags->outputs.control_mesh,
                 "The control mesh, with the input's faces in their order")
      ->type_name("FILE");
  app.add_option("--report", flags->outputs.report,
                 "The summary (limn.v1.Summary) as JSON: sizes, sweeps, errors, times")
      ->type_name("FILE.json");
}

void AddCommonFlags(CLI::App& app, SurfaceFlags* flags) {
  AddTessellationFlags(app, &flags->job);
  AddConnectionFlags(app, &flags->connection);
  app.add_flag("-q,--quiet", flags->quiet, "No table and no progress bar");
}

}  // namespace limn::cli
