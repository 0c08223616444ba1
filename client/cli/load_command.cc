// SPDX-License-Identifier: MIT
// `limn load`: puts a load on a server and tells how it bears it.
#include <atomic>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/cli/commands.h"
#include "client/cli/connection.h"
#include "client/cli/interrupt_watcher.h"
#include "client/cli/progress_bar.h"
#include "client/cli/staged_files.h"
#include "client/load/arrivals.h"
#include "client/load/generator.h"
#include "client/load/load_plot.h"
#include "client/load/load_report.h"
#include "client/load/mix.h"
#include "client/load/process_probe.h"
#include "client/load/sweep.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

struct LoadFlags {
  ConnectionOptions connection;
  std::string arrivals = "poisson";
  load::ArrivalOptions schedule;
  std::string replay;
  std::uint64_t clients = 0;
  std::string mix = "small=1";
  load::MixOptions jobs;
  std::uint64_t connections = 4;
  std::uint64_t most_outstanding = 4096;
  std::string objectives;
  bool sweep = false;
  std::optional<int> server_pid;
  std::string report;
  std::string csv;
  std::string plot;
  bool quiet = false;
};

// What the flags make, checked before any load.
struct Plan {
  load::LoadOptions options;
  load::ArrivalOptions schedule;
  std::vector<load::Objective> objectives;
  std::unique_ptr<load::Mix> mix;
};

absl::StatusOr<Plan> MakePlan(const LoadFlags& flags) {
  Plan plan;
  plan.options = {.server = flags.connection.server,
                  .security = flags.connection.security,
                  .client = {.deadline_seconds = flags.connection.deadline_seconds.value_or(0)},
                  .connections = flags.connections,
                  .most_outstanding = flags.most_outstanding,
                  .clients = flags.clients,
                  .seconds = flags.schedule.seconds};
  plan.schedule = flags.schedule;
  plan.schedule.seed = flags.jobs.seed;
  LIMN_ASSIGN_OR_RETURN(plan.schedule.kind, load::ParseArrivalKind(flags.arrivals));
  if (!flags.objectives.empty()) {
    LIMN_ASSIGN_OR_RETURN(plan.objectives, load::ParseObjectives(flags.objectives));
  }
  if (!flags.replay.empty()) {
    LIMN_ASSIGN_OR_RETURN(plan.options.arrivals, load::ReadArrivals(flags.replay));
    plan.options.seconds = 0;
  } else if (flags.clients == 0) {
    LIMN_ASSIGN_OR_RETURN(plan.options.arrivals, load::MakeArrivals(plan.schedule));
  }
  load::MixOptions jobs = flags.jobs;
  LIMN_ASSIGN_OR_RETURN(jobs.shares, load::ParseShares(flags.mix));
  LIMN_ASSIGN_OR_RETURN(load::Mix mix, load::Mix::Make(jobs));
  plan.mix = std::make_unique<load::Mix>(std::move(mix));
  return plan;
}

class LoadRun {
 public:
  LoadRun(const LoadFlags& flags, Plan plan)
      : flags_(flags), plan_(std::move(plan)), bar_(!flags.quiet) {}

  ExitStatus Run() {
    const InterruptWatcher watcher([this] { stop_ = true; });
    return flags_.sweep ? Sweep() : Once();
  }

 private:
  absl::StatusOr<load::LoadReport> Load(load::LoadResult* result) {
    std::unique_ptr<load::ProcessProbe> probe;
    if (flags_.server_pid.has_value()) {
      LIMN_ASSIGN_OR_RETURN(probe, load::ProcessProbe::Start(*flags_.server_pid));
    }
    const double all = static_cast<double>(plan_.options.arrivals.size());
    const auto show = [&](std::uint64_t sent, std::uint64_t ended) {
      bar_.Show("load", all > 0 ? static_cast<double>(sent) / all : ProgressBar::kUnknown,
                absl::StrFormat("%d sent, %d ended", sent, ended));
    };
    LIMN_ASSIGN_OR_RETURN(*result, load::RunLoad(plan_.options, plan_.mix.get(), stop_, show));
    bar_.Clear();
    load::LoadReport report = load::MakeReport(*result);
    if (probe != nullptr) report.process = probe->Stop();
    return report;
  }

  ExitStatus Once() {
    load::LoadResult result;
    const absl::StatusOr<load::LoadReport> report = Load(&result);
    if (!report.ok()) return FailAtServer(flags_.connection.server, report.status());
    if (!flags_.quiet) std::fputs(load::ReportText(*report).c_str(), stdout);
    const absl::Status written = Write(*report, result);
    if (!written.ok()) return FailWithFile(written);
    if (stop_) {
      PrintError("interrupted; the report is of what was sent until then");
      return ExitStatus::kInterrupted;
    }
    const std::vector<std::string> violations = load::Violations(plan_.objectives, *report);
    if (violations.empty()) return ExitStatus::kOk;
    PrintError("not kept: " + absl::StrJoin(violations, "; "));
    return ExitStatus::kObjective;
  }

  absl::Status Write(const load::LoadReport& report, const load::LoadResult& result) const {
    StagedFiles files;
    for (const auto& [path, text] : {std::pair(flags_.report, load::ReportJson(report)),
                                     std::pair(flags_.csv, load::SamplesCsv(result))}) {
      if (path.empty()) continue;
      LIMN_ASSIGN_OR_RETURN(io::OutputFile* const file, files.Create(path));
      file->Append(text);
    }
    LIMN_RETURN_IF_ERROR(files.Commit());
    return flags_.plot.empty() ? absl::OkStatus() : load::PlotLatencies(result, flags_.plot);
  }

  ExitStatus Sweep() {
    const auto run = [this](double rate) -> absl::StatusOr<load::LoadReport> {
      if (stop_) return absl::CancelledError("interrupted");
      plan_.schedule.rate = rate;
      LIMN_ASSIGN_OR_RETURN(plan_.options.arrivals, load::MakeArrivals(plan_.schedule));
      load::LoadResult result;
      return Load(&result);
    };
    const absl::StatusOr<load::SweepResult> result =
        load::FindKnee({.first_rate = flags_.schedule.rate, .objectives = plan_.objectives}, run);
    if (stop_) return FailInterrupted();
    if (!result.ok()) return FailAtServer(flags_.connection.server, result.status());
    std::fputs(load::SweepText(*result).c_str(), stdout);
    return result->knee > 0 ? ExitStatus::kOk : ExitStatus::kObjective;
  }

  const LoadFlags& flags_;
  Plan plan_;
  ProgressBar bar_;
  std::atomic<bool> stop_{false};
};

ExitStatus RunLoadCommand(const LoadFlags& flags) {
  absl::StatusOr<Plan> plan = MakePlan(flags);
  if (!plan.ok()) return FailWithFile(plan.status());
  return LoadRun(flags, *std::move(plan)).Run();
}

void AddScheduleFlags(CLI::App& app, LoadFlags* flags) {
  app.add_option("--rate", flags->schedule.rate, "Jobs per second of an open loop")
      ->capture_default_str()
      ->type_name("R");
  app.add_option("--duration", flags->schedule.seconds, "Seconds for which jobs are sent")
      ->capture_default_str()
      ->type_name("S");
  CLI::Option* const arrivals =
      app.add_option("--arrivals", flags->arrivals,
                     "constant; poisson: as of many clients; burst: --burst at once; ramp: from 0 "
                     "to the rate")
          ->check(CLI::IsMember(load::ArrivalKindNames()))
          ->capture_default_str()
          ->type_name("KIND");
  app.add_option("--burst", flags->schedule.burst, "Jobs of a burst")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str()
      ->type_name("N");
  CLI::Option* const replay =
      app.add_option("--replay", flags->replay,
                     "Times in seconds, one in a line, at which jobs are sent")
          ->excludes(arrivals)
          ->type_name("FILE");
  app.add_option("--clients", flags->clients,
                 "A closed loop instead: so many clients, each sending its next job when the last "
                 "one has ended")
      ->check(CLI::Range(1, 100'000))
      ->excludes(arrivals)
      ->excludes(replay)
      ->type_name("N");
}

void AddJobFlags(CLI::App& app, LoadFlags* flags) {
  app.add_option("--mix", flags->mix,
                 "Shares of kinds of jobs: small, large, hostile (to be refused), slow (reads ten "
                 "messages a second), cancelled")
      ->capture_default_str()
      ->type_name("KIND=SHARE,...");
  const auto add = [&](const char* flag, auto* value, auto least, auto most, const char* help) {
    app.add_option(flag, *value, help)
        ->check(CLI::Range(least, most))
        ->capture_default_str()
        ->type_name("N");
  };
  add("--small-vertices", &flags->jobs.small_vertices, 32, 1'000'000, "Of small and slow jobs");
  add("--large-vertices", &flags->jobs.large_vertices, 32, 16'000'000,
      "Of large and cancelled jobs");
  add("--small-level", &flags->jobs.small_level, 0, 6,
      "Level of small jobs; slow ones have 2 more");
  add("--large-level", &flags->jobs.large_level, 0, 6, "Level of large and cancelled jobs");
  add("--seed", &flags->jobs.seed, 0, 1'000'000'000, "Of meshes, times and kinds");
}

}  // namespace

void AddLoadCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand(
      "load", "Put a load on a server; latencies count from the intended time of sending");
  const auto flags = std::make_shared<LoadFlags>();
  flags->connection.server = "127.0.0.1:7410";
  AddServerFlags(*command, &flags->connection);
  AddScheduleFlags(*command, flags.get());
  AddJobFlags(*command, flags.get());
  command->add_option("--connections", flags->connections, "Connections, which take turns")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->type_name("N");
  command
      ->add_option("--max-outstanding", flags->most_outstanding,
                   "Jobs under way, above which others are not sent and count as dropped")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str()
      ->type_name("N");
  command
      ->add_option("--slo", flags->objectives,
                   "What is to be kept, such as p99=50,errors=0.01 (ms; share of jobs); else the "
                   "exit status is 5")
      ->type_name("NAME=BOUND,...");
  command->add_flag("--sweep", flags->sweep,
                    "Raise the rate from --rate on, each for --duration, until --slo is not kept; "
                    "find the highest that is");
  command->get_option("--sweep")->excludes("--replay")->excludes("--clients");
  command
      ->add_option("--server-pid", flags->server_pid,
                   "Process on this machine whose memory and processor time are reported")
      ->check(CLI::Range(1, 1 << 30))
      ->type_name("PID");
  command->add_option("--report", flags->report, "The report as JSON")->type_name("FILE.json");
  command->add_option("--csv", flags->csv, "A line per job")->type_name("FILE.csv");
  command->add_option("--plot", flags->plot, "Latency over percentile, by gnuplot")
      ->type_name("FILE.svg");
  for (const char* option : {"--report", "--csv", "--plot"}) {
    command->get_option("--sweep")->excludes(option);
  }
  command->add_flag("-q,--quiet", flags->quiet, "No report on standard output, no progress bar");
  command->callback([flags, status] { *status = RunLoadCommand(*flags); });
}

}  // namespace limn::cli
