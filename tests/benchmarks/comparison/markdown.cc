// SPDX-License-Identifier: MIT
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/benchmarks/comparison/report.h"

namespace limn::comparison {
namespace {

// Three significant digits, without exponents.
std::string Short(double value) {
  if (value >= 100) return absl::StrFormat("%.0f", value);
  if (value >= 10) return absl::StrFormat("%.1f", value);
  if (value >= 1) return absl::StrFormat("%.2f", value);
  return absl::StrFormat("%.3g", value);
}

std::string Megabytes(double bytes) { return bytes > 0 ? Short(bytes / 1e6) : ""; }

// Goals are for the fastest of their rivals.
std::string GoalText(const Cell& cell, const Outcome& outcome) {
  const double factor = GoalFactor(cell.task, outcome.rival);
  if (factor == 0) return "";
  std::string text;
  for (const std::size_t limn : {0, 1}) {
    if (Fastest(cell, outcome.rival, limn) != &outcome) continue;
    absl::StrAppend(&text, text.empty() ? "" : "; ", limn + 1, " thread", limn == 0 ? "" : "s", " ",
                    factor, ": ", outcome.over_limn[limn] >= factor ? "met" : "not met");
  }
  return text;
}

void AddRow(const Cell& cell, const Outcome& outcome, std::string* text) {
  absl::StrAppendFormat(text, "| %s | %d | %s | %d | ", MeshesName(cell.meshes), cell.vertices,
                        outcome.name, outcome.threads);
  if (!outcome.missing.empty()) {
    absl::StrAppendFormat(text, "%s | | | | | |\n", outcome.missing);
    return;
  }
  std::string difference = absl::StrFormat("%.0e", outcome.point_difference);
  if (outcome.normal_difference > 0) {
    absl::StrAppendFormat(&difference, ", normals %.0e", outcome.normal_difference);
  }
  if (!outcome.agrees) difference += " DISAGREES";
  absl::StrAppendFormat(text, "%s | %s | %s | %s | %s | %s |\n", Short(1e3 * outcome.seconds),
                        Short(outcome.over_limn[0]), Short(outcome.over_limn[1]),
                        Megabytes(outcome.peak_bytes), difference, GoalText(cell, outcome));
}

void AddTask(const Report& report, const TaskInfo& task, std::string* text) {
  bool any = false;
  for (const Cell& cell : report.cells) {
    if (cell.task != task.task) continue;
    if (!any) {
      absl::StrAppendFormat(
          text,
          "\n### %s\n\n| mesh | vertices | who | threads | ms | / Limn | / Limn, 2 threads | peak "
          "MB | difference | goal |\n| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | --- | "
          "--- |\n",
          task.title);
      any = true;
    }
    for (const Outcome& outcome : cell.outcomes) AddRow(cell, outcome, text);
  }
}

void AddKernels(const Report& report, std::string* text) {
  if (report.kernels.bandwidth.empty()) return;
  *text +=
      "\n### Kernels and bandwidth\n\n| threads | copy, GB/s | triad, GB/s |\n| ---: | ---: | "
      "---: |\n";
  for (const Bandwidth& bandwidth : report.kernels.bandwidth) {
    absl::StrAppendFormat(text, "| %d | %s | %s |\n", bandwidth.threads,
                          Short(bandwidth.copy / 1e9), Short(bandwidth.triad / 1e9));
  }
  *text +=
      "\n| kernel | vertices | threads | ms | ns per vertex | GB/s | time / bound | goal |\n| --- "
      "| ---: | ---: | ---: | ---: | ---: | ---: | --- |\n";
  for (const KernelOutcome& kernel : report.kernels.kernels) {
    absl::StrAppendFormat(text, "| %s | %d | %d | %s | %s | %s | %s | 1.5: %s |\n", kernel.name,
                          kernel.vertices, kernel.threads, Short(1e3 * kernel.seconds),
                          Short(1e9 * kernel.seconds / static_cast<double>(kernel.vertices)),
                          Short(kernel.bytes / kernel.seconds / 1e9), Short(kernel.over_bound),
                          kernel.over_bound <= 1.5 ? "met" : "not met");
  }
}

void AddJobs(const Report& report, std::string* text) {
  if (report.jobs.empty()) return;
  *text +=
      "\n### Memory of whole jobs, level 2 with normals\n\n| job | vertices | s | peak MB | / "
      "result | / result and last stage | goal |\n| --- | ---: | ---: | ---: | ---: | ---: | --- "
      "|\n";
  for (const JobOutcome& job : report.jobs) {
    const double over = job.peak_bytes / job.held_bytes;
    absl::StrAppendFormat(text, "| %s | %d | %s | %s | %s | %s | 1.3: %s |\n", job.name,
                          job.vertices, Short(job.seconds), Megabytes(job.peak_bytes),
                          Short(job.peak_bytes / job.result_bytes), Short(over),
                          over <= 1.3 ? "met" : "not met");
  }
}

void AddGoals(const Report& report, std::string* text) {
  *text += "\n### Goals\n\n| goal | found | |\n| --- | --- | --- |\n";
  for (const Verdict& verdict : JudgeGoals(report)) {
    std::string met = verdict.looked_at == 0 ? "" : "met";
    if (verdict.met < verdict.looked_at) {
      met = verdict.met == 0 ? "not met"
                             : absl::StrFormat("met in %d of %d", verdict.met, verdict.looked_at);
    }
    absl::StrAppendFormat(text, "| %s | %s | %s |\n", verdict.goal, verdict.found, met);
  }
}

}  // namespace

std::string Markdown(const Report& report) {
  std::string text =
      "Medians of rounds in which all take turns; \"/ Limn\" is the median of the ratios within "
      "rounds, to Limn with one thread and with two. ms, and ratios with two threads: by the "
      "clock; "
      "ratios of one thread to one: processor time. Peak MB: resident memory beyond what was "
      "there before. Difference: to Limn's answer (solvers: to the solution) over the bounding "
      "box.\n";
  for (const TaskInfo& task : AllTasks()) AddTask(report, task, &text);
  AddKernels(report, &text);
  AddJobs(report, &text);
  AddGoals(report, &text);
  return text;
}

}  // namespace limn::comparison
