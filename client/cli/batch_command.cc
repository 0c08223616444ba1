// SPDX-License-Identifier: MIT
// `limn batch`: many mesh files in, their limit surfaces out.
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "absl/strings/str_cat.h"
#include "client/batch.h"
#include "client/cli/batch_journal.h"
#include "client/cli/batch_manifest.h"
#include "client/cli/batch_outputs.h"
#include "client/cli/batch_report.h"
#include "client/cli/batch_runner.h"
#include "client/cli/commands.h"
#include "client/cli/connection.h"
#include "client/cli/constraints_file.h"
#include "client/cli/interrupt_watcher.h"
#include "client/cli/job_options.h"
#include "client/cli/report.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

struct BatchFlags {
  std::string jobs;
  BatchOutputs outputs;
  BatchEntry defaults;
  ConnectionOptions connection;
  BatchOptions batch;
  bool resume = false;
  bool quiet = false;
};

// Results among the meshes would be meshes of the next run.
absl::Status CheckFolders(const BatchFlags& flags) {
  std::error_code error;
  if (!std::filesystem::is_directory(flags.jobs, error) ||
      FileIdentity(flags.jobs) != FileIdentity(flags.outputs.folder)) {
    return absl::OkStatus();
  }
  return MakeError(
      "-o is the folder of the meshes",
      {.reason = Reason::kInvalidOption, .field = "output", .remedy = "Name another one"});
}

std::string Counted(std::uint64_t count, std::uint64_t of) {
  return absl::StrCat(WithCommas(count), " of ", WithCommas(of), of == 1 ? " job" : " jobs");
}

// How the batch itself ended.
struct End {
  absl::Status status;
  // The results could not be written.
  bool disk = false;
  bool interrupted = false;
};

End RunJobs(const BatchFlags& flags, const Client& client, const std::string& name,
            BatchRunner* runner) {
  BatchOptions options = flags.batch;
  options.name = name;
  ClientBatch batch(client, options);
  const InterruptWatcher watcher([&batch] { batch.Cancel(); });
  End end;
  end.status = batch.Run(
      {.next = [&] { return runner->Next(); },
       .on_result =
           [&](BatchResult result) {
             absl::Status taken = runner->Take(std::move(result));
             end.disk = end.disk || !taken.ok();
             return taken;
           },
       .on_job_progress = [&](const std::string& id,
                              const v1::Progress& progress) { runner->Show(id, progress); }});
  end.interrupted = watcher.interrupted() && !end.status.ok();
  return end;
}

absl::Status WriteBatchReport(const std::string& path, const std::string& json) {
  if (path.empty()) return absl::OkStatus();
  LIMN_ASSIGN_OR_RETURN(const auto file, io::OutputFile::Create(path));
  file->Append(json);
  return file->Commit();
}

ExitStatus Answer(const BatchFlags& flags, const End& end, const BatchCounts& counts,
                  std::uint64_t jobs) {
  const std::string done =
      Counted(counts.succeeded + counts.skipped, jobs) + " done; --resume goes on with the others";
  if (end.interrupted) {
    PrintError("interrupted; " + done);
    return ExitStatus::kInterrupted;
  }
  if (!end.status.ok()) {
    const ExitStatus status =
        end.disk ? FailWithFile(end.status) : FailAtServer(flags.connection.server, end.status);
    PrintError(done);
    return status;
  }
  if (counts.failed == 0) return ExitStatus::kOk;
  PrintError(Counted(counts.failed, jobs) + " failed; --resume tries those again");
  return ExitStatus::kPartial;
}

ExitStatus RunBatch(const BatchFlags& flags) {
  absl::Status status = CheckFolders(flags);
  if (!status.ok()) return FailWithFile(status);
  const absl::StatusOr<std::vector<BatchEntry>> entries =
      ReadBatchEntries(flags.jobs, flags.defaults);
  if (!entries.ok()) return FailWithFile(entries.status());
  status = CheckBatchOutputs(
      *entries, flags.outputs,
      {flags.jobs, flags.defaults.constraints, BatchJournal::PathIn(flags.outputs.folder)});
  if (!status.ok()) return FailWithFile(status);
  const auto journal = BatchJournal::Open(flags.outputs.folder, flags.resume);
  if (!journal.ok()) return FailWithFile(journal.status());
  const absl::StatusOr<Connection> connection = Connection::Open(flags.connection);
  if (!connection.ok()) return FailWithJob(connection.status());

  const auto start = std::chrono::steady_clock::now();
  ProgressBar bar(!flags.quiet);
  BatchRunner runner(*entries, flags.outputs, journal->get(), &bar);
  const End end = RunJobs(flags, connection->client(), (*journal)->name(), &runner);
  bar.Clear();
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;

  const std::vector<BatchOutcome> outcomes = runner.outcomes();
  if (!flags.quiet) std::fputs(BatchTable(outcomes, time.count()).c_str(), stdout);
  status = WriteBatchReport(flags.outputs.report, BatchJson(*entries, outcomes, time.count()));
  const ExitStatus answer = Answer(flags, end, CountOutcomes(outcomes), entries->size());
  return status.ok() ? answer : FailWithFile(status);
}

void AddOutputFlags(CLI::App& app, BatchFlags* flags) {
  app.add_option(
         "-o,--output", flags->outputs.folder,
         "Folder of the results, made if need be: for each job the surface NAME.FORMAT, and "
         "the journal limn-batch.jsonl")
      ->required()
      ->type_name("DIR");
  flags->outputs.formats = {"ply"};
  app.add_option(
         "--format", flags->outputs.formats,
         "Format of the surfaces: obj, off, ply, stl or glb; may be given again for further "
         "ones")
      ->check(CLI::IsMember({"obj", "off", "ply", "stl", "glb"}))
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->capture_default_str();
  app.add_flag("--control-mesh", flags->outputs.control_mesh,
               "Write NAME.control.FORMAT too, the control mesh");
  app.add_flag("--job-reports", flags->outputs.job_reports,
               "Write NAME.json too, the job's summary (limn.v1.Summary)");
  app.add_option("--report", flags->outputs.report,
                 "What became of each job, as JSON: status, reason, message, times")
      ->type_name("FILE.json");
}

void AddBatchFlags(CLI::App& app, BatchFlags* flags) {
  app.add_option(
         "JOBS", flags->jobs,
         "A folder of meshes, or a file with a JSON object per job and line: input, and if "
         "wanted id, output (names of the job and of its files), constraints, scheme, level "
         "or chordTolerance, repair; for what a line does not say the flags hold")
      ->required();
  AddOutputFlags(app, flags);
  app.add_flag(
      "--resume", flags->resume,
      "Go on with the batch in the output folder: jobs whose results are there, of the same "
      "input and options, are left out");
  app.add_option("--window", flags->batch.window,
                 "Jobs that the server has at a time, at the most [what it takes]")
      ->check(CLI::Range(1, 10'000))
      ->type_name("N");
  app.add_option("--tries", flags->batch.max_tries,
                 "How often to try in a row, when the server is gone or has no room")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  AddConstraintsFlag(app, &flags->defaults.constraints);
}

}  // namespace

void AddBatchCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "batch", "Find the smooth surfaces through the vertices of many meshes, on one stream");
  const auto flags = std::make_shared<BatchFlags>();
  AddBatchFlags(*command, flags.get());
  AddSolveFlags(*command, &flags->defaults.options);
  AddTessellationFlags(*command, &flags->defaults.options);
  AddConnectionFlags(*command, &flags->connection);
  command->add_flag("-q,--quiet", flags->quiet, "No table and no progress bar");
  command->callback([flags, status] { *status = RunBatch(*flags); });
}

}  // namespace limn::cli
