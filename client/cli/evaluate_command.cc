// SPDX-License-Identifier: MIT
// `limn evaluate`: a mesh file and parameters in, points of its smooth surface out.
#include <cerrno>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "client/cli/commands.h"
#include "client/cli/connection.h"
#include "client/cli/constraints_file.h"
#include "client/cli/interrupt_watcher.h"
#include "client/cli/job_options.h"
#include "client/cli/job_runner.h"
#include "client/cli/outputs.h"
#include "client/cli/progress_bar.h"
#include "client/cli/report.h"
#include "client/cli/samples_file.h"
#include "client/cli/solve_warning.h"
#include "client/cli/staged_files.h"
#include "client/io/mesh_reader.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

struct EvaluateFlags {
  std::string input;
  std::string parameters;
  // Empty for none.
  std::string constraints;
  // Empty: standard output.
  OutputPaths outputs;
  std::optional<std::string> format;
  JobOptions job;
  ConnectionOptions connection;
  bool quiet = false;
};

const std::map<std::string, SampleFormat> kFormats = {
    {"text", SampleFormat::kText}, {"csv", SampleFormat::kCsv}, {"json", SampleFormat::kJson}};

absl::StatusOr<SampleFormat> FormatOf(const EvaluateFlags& flags) {
  if (flags.format) return kFormats.at(*flags.format);
  if (flags.outputs.samples.empty()) return SampleFormat::kText;
  return SampleFormatOf(flags.outputs.samples);
}

absl::Status CheckFiles(const EvaluateFlags& flags) {
  LIMN_RETURN_IF_ERROR(FormatOf(flags).status());
  const std::string parameters = flags.parameters == "-" ? "" : flags.parameters;
  return CheckOutputs(flags.outputs, {flags.input, flags.constraints, parameters});
}

absl::StatusOr<v1::InterpolateHeader> MakeHeader(const EvaluateFlags& flags) {
  v1::InterpolateHeader header = MakeJobHeader(flags.job, {.surface = false});
  if (!flags.constraints.empty()) {
    LIMN_ASSIGN_OR_RETURN(*header.mutable_constraints(), ReadConstraintsFile(flags.constraints));
  }
  return header;
}

absl::Status WriteToStandardOutput(SampleFormat format, const ParametersFile& file,
                                   const EvaluateResult& result) {
  bool ok = true;
  WriteSamples(format, file.parameters, result, [&](std::string_view text) {
    ok = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
    return ok;
  });
  if (ok && std::fflush(stdout) == 0) return absl::OkStatus();
  return absl::ErrnoToStatus(errno, "cannot write to standard output");
}

// Everything into files, to be committed; samples without a file to standard output.
absl::Status Write(const EvaluateFlags& flags, const ParametersFile& file,
                   const EvaluateResult& result, StagedFiles* files) {
  LIMN_ASSIGN_OR_RETURN(const SampleFormat format, FormatOf(flags));
  LIMN_RETURN_IF_ERROR(WriteReport(flags.outputs.report, result.summary, files));
  if (flags.outputs.samples.empty()) return WriteToStandardOutput(format, file, result);
  LIMN_ASSIGN_OR_RETURN(io::OutputFile* const out, files->Create(flags.outputs.samples));
  WriteSamples(format, file.parameters, result, [&](std::string_view text) {
    out->Append(text);
    return out->ok();
  });
  if (flags.quiet) return absl::OkStatus();
  std::fputs(SummaryTable(result.summary).c_str(), stdout);
  if (std::fflush(stdout) == 0) return absl::OkStatus();
  return absl::ErrnoToStatus(errno, "cannot write to standard output");
}

ExitStatus Run(const EvaluateFlags& flags) {
  absl::Status status = CheckFiles(flags);
  if (!status.ok()) return FailWithFile(status);
  absl::StatusOr<v1::InterpolateHeader> header = MakeHeader(flags);
  if (!header.ok()) return FailWithFile(header.status());
  const absl::StatusOr<ParametersFile> file = ReadParametersFile(flags.parameters);
  if (!file.ok()) return FailWithFile(file.status());

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
  const absl::StatusOr<EvaluateResult> result =
      RunEvaluation(connection->client(), {*std::move(header), *std::move(mesh)}, file->parameters,
                    &bar, &canceller);
  bar.Clear();
  if (canceller.cancelled()) return FailInterrupted();
  if (!result.ok()) {
    status = NameConstraintsFile(result.status(), flags.constraints);
    return FailAtServer(flags.connection.server, NameParametersFile(status, *file));
  }

  StagedFiles files([&canceller] { return canceller.cancelled(); });
  status = Write(flags, *file, *result, &files);
  if (canceller.cancelled()) return FailInterrupted();
  WarnAboutSolve(result->summary.solve(), flags.job);
  if (status.ok()) status = files.Commit();
  return status.ok() ? ExitStatus::kOk : FailWithFile(status);
}

}  // namespace

void AddEvaluateCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "evaluate", "Points, normals and derivatives of a mesh's smooth surface at any parameters");
  const auto flags = std::make_shared<EvaluateFlags>();
  command->add_option("IN", flags->input, "Mesh, open or closed: .obj, .off, .ply or .stl")
      ->required();
  command
      ->add_option(
          "--at", flags->parameters,
          "Parameters: lines 'face corner u v', or JSON of limn.v1.ParameterBlock; - is "
          "standard input. Faces and their corners count from 0; u in [0, 1] runs from the "
          "corner's vertex to the middle of the edge that leaves it, v to that of the edge "
          "that enters it; (1, 1) is the middle of the face")
      ->type_name("FILE|-")
      ->required();
  command
      ->add_option("-o,--output", flags->outputs.samples,
                   "Where to write: .txt, .csv or .json [standard output]")
      ->type_name("OUT");
  command
      ->add_option("--format", flags->format,
                   "text, csv or json [by the extension, else text: a line 'x y z', normal, "
                   "derivative along u, along v, per parameter]")
      ->check(CLI::IsMember(std::vector<std::string>{"text", "csv", "json"}))
      ->type_name("FORMAT");
  command
      ->add_option("--report", flags->outputs.report,
                   "The summary (limn.v1.Summary) as JSON: sizes, sweeps, errors, times")
      ->type_name("FILE.json");
  AddConstraintsFlag(*command, &flags->constraints);
  AddSolveFlags(*command, &flags->job);
  AddConnectionFlags(*command, &flags->connection);
  command->add_flag("-q,--quiet", flags->quiet, "No table and no progress bar");
  command->callback([flags, status] { *status = Run(*flags); });
}

}  // namespace limn::cli
