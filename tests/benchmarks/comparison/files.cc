// SPDX-License-Identifier: MIT
// What programs read: JSON, and tables for the plot.
#include <fstream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "tests/benchmarks/comparison/report.h"

namespace limn::comparison {
namespace {

std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

// Not a number of JSON where a difference is infinite.
std::string Number(double value) {
  return value - value == 0 ? absl::StrFormat("%.6g", value) : "null";
}

const TaskInfo& InfoOf(Task task) {
  for (const TaskInfo& info : AllTasks()) {
    if (info.task == task) return info;
  }
  return AllTasks().front();
}

std::string OutcomeJson(const Outcome& outcome) {
  std::string text = absl::StrFormat("{\"name\": %s, \"rival\": %s, \"threads\": %d",
                                     Quoted(outcome.name), Quoted(outcome.rival), outcome.threads);
  if (!outcome.missing.empty()) {
    return absl::StrCat(text, ", \"missing\": ", Quoted(outcome.missing), "}");
  }
  return absl::StrFormat(
      "%s, \"seconds\": %s, \"processor_seconds\": %s, \"over_limn_1\": %s, \"over_limn_2\": %s, "
      "\"rounds\": %d, "
      "\"point_difference\": %s, \"normal_difference\": %s, \"agrees\": %s, \"peak_bytes\": %s}",
      text, Number(outcome.seconds), Number(outcome.processor_seconds),
      Number(outcome.over_limn[0]), Number(outcome.over_limn[1]), outcome.rounds,
      Number(outcome.point_difference), Number(outcome.normal_difference),
      outcome.agrees ? "true" : "false", Number(outcome.peak_bytes));
}

std::string CellJson(const Cell& cell) {
  return absl::StrFormat(
      "{\"task\": %s, \"meshes\": %s, \"vertices\": %d, \"outcomes\": [\n    %s]}",
      Quoted(InfoOf(cell.task).name), Quoted(MeshesName(cell.meshes)), cell.vertices,
      absl::StrJoin(cell.outcomes, ",\n    ", [](std::string* out, const Outcome& outcome) {
        *out += OutcomeJson(outcome);
      }));
}

std::string KernelJson(const KernelOutcome& kernel) {
  return absl::StrFormat(
      "{\"name\": %s, \"threads\": %d, \"vertices\": %d, \"seconds\": %s, \"bytes\": %s, "
      "\"over_bound\": %s}",
      Quoted(kernel.name), kernel.threads, kernel.vertices, Number(kernel.seconds),
      Number(kernel.bytes), Number(kernel.over_bound));
}

std::string JobJson(const JobOutcome& job) {
  return absl::StrFormat(
      "{\"name\": %s, \"vertices\": %d, \"seconds\": %s, \"peak_bytes\": %s, \"result_bytes\": "
      "%s, \"held_bytes\": %s}",
      Quoted(job.name), job.vertices, Number(job.seconds), Number(job.peak_bytes),
      Number(job.result_bytes), Number(job.held_bytes));
}

template <class T, class F>
std::string List(const char* name, const std::vector<T>& values, const F& json) {
  return absl::StrFormat(" \"%s\": [\n  %s]", name,
                         absl::StrJoin(values, ",\n  ", [&](std::string* out, const T& value) {
                           *out += json(value);
                         }));
}

}  // namespace

std::string Json(const Report& report) {
  const auto bandwidth = [](const Bandwidth& b) {
    return absl::StrFormat("{\"threads\": %d, \"copy\": %s, \"triad\": %s}", b.threads,
                           Number(b.copy), Number(b.triad));
  };
  const auto verdict = [](const Verdict& v) {
    return absl::StrFormat("{\"goal\": %s, \"found\": %s, \"looked_at\": %d, \"met\": %d}",
                           Quoted(v.goal), Quoted(v.found), v.looked_at, v.met);
  };
  const std::string lists[] = {
      List("cells", report.cells, CellJson), List("bandwidth", report.kernels.bandwidth, bandwidth),
      List("kernels", report.kernels.kernels, KernelJson), List("jobs", report.jobs, JobJson),
      List("goals", JudgeGoals(report), verdict)};
  return absl::StrCat("{\n", absl::StrJoin(lists, ",\n"), "\n}\n");
}

void WriteRatios(const Report& report, const std::string& folder) {
  for (const TaskInfo& task : AllTasks()) {
    const Meshes meshes = task.triangles_only ? Meshes::kTriangles : Meshes::kPolygons;
    std::string titles;
    std::string rows;
    for (const Cell& cell : report.cells) {
      if (cell.task != task.task || cell.meshes != meshes) continue;
      titles = "vertices";
      absl::StrAppend(&rows, cell.vertices);
      for (const Outcome& outcome : cell.outcomes) {
        absl::StrAppend(&titles, "\t", outcome.name, outcome.threads == 1 ? "" : ", 2 threads");
        absl::StrAppend(&rows, "\t",
                        outcome.missing.empty() ? Number(outcome.over_limn[0]) : "NaN");
      }
      rows += "\n";
    }
    if (rows.empty()) continue;
    std::ofstream(absl::StrCat(folder, "/ratios-", task.name, ".tsv")) << titles << "\n" << rows;
  }
}

}  // namespace limn::comparison
