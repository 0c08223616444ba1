// SPDX-License-Identifier: MIT
#include "client/load/load_report.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/json_object.h"

namespace limn::load {
namespace {

using cli::JsonObject;

double Rate(double count, double seconds) { return seconds > 0 ? count / seconds : 0; }

// Small and large jobs are those that a service's promises are about.
bool IsOrdinary(JobKind kind) { return kind == JobKind::kSmall || kind == JobKind::kLarge; }

using Groups = std::map<std::string, std::vector<double>>;

void Add(JobKind kind, double milliseconds, Groups* groups) {
  (*groups)[std::string(JobKindName(kind))].push_back(milliseconds);
  if (IsOrdinary(kind)) (*groups)["all"].push_back(milliseconds);
}

std::map<std::string, Percentiles> AllPercentiles(Groups groups) {
  std::map<std::string, Percentiles> all;
  for (auto& [name, values] : groups) all[name] = PercentilesOf(std::move(values));
  return all;
}

void AppendTable(absl::string_view title, const std::map<std::string, Percentiles>& rows,
                 std::string* text) {
  if (rows.empty()) return;
  absl::StrAppendFormat(text, "\n%-28s %9s %9s %9s %9s %9s %9s %9s\n", title, "jobs", "mean", "p50",
                        "p90", "p99", "p99.9", "max");
  for (const auto& [name, p] : rows) {
    absl::StrAppendFormat(text, "  %-26s %9d %9.2f %9.2f %9.2f %9.2f %9.2f %9.2f\n", name, p.count,
                          p.mean, p.p50, p.p90, p.p99, p.p999, p.max);
  }
}

JsonObject ToJson(const std::map<std::string, Percentiles>& rows) {
  JsonObject object;
  for (const auto& [name, p] : rows) {
    object.Add(name, JsonObject()
                         .Add("count", p.count)
                         .AddNumber("mean", p.mean)
                         .AddNumber("p50", p.p50)
                         .AddNumber("p90", p.p90)
                         .AddNumber("p99", p.p99)
                         .AddNumber("p99.9", p.p999)
                         .AddNumber("max", p.max));
  }
  return object;
}

}  // namespace

Percentiles PercentilesOf(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double percent) {
    const double rank = std::ceil(percent / 100 * static_cast<double>(values.size()) - 1e-9);
    return values[std::max<std::size_t>(static_cast<std::size_t>(rank), 1) - 1];
  };
  return {.count = values.size(),
          .mean = std::accumulate(values.begin(), values.end(), 0.0) /
                  static_cast<double>(values.size()),
          .p50 = at(50),
          .p90 = at(90),
          .p99 = at(99),
          .p999 = at(99.9),
          .max = values.back()};
}

LoadReport MakeReport(const LoadResult& result) {
  LoadReport report = {.sending_seconds = result.sending_seconds,
                       .seconds = result.seconds,
                       .offered = result.offered,
                       .sent = result.samples.size(),
                       .late = result.late,
                       .dropped = result.dropped};
  Groups latency;
  Groups first_tile;
  Groups last_tile;
  Groups stages;
  double vertices = 0;
  double bytes = 0;
  for (const Sample& sample : result.samples) {
    ++report.outcomes[absl::StrCat(std::string(JobKindName(sample.kind)), " ", sample.outcome)];
    bytes += static_cast<double>(sample.bytes_sent + sample.bytes_received);
    if (!sample.good) continue;
    ++report.good;
    vertices += sample.outcome == "OK" ? static_cast<double>(sample.vertices) : 0;
    Add(sample.kind, 1e3 * (sample.ended - sample.intended), &latency);
    if (sample.first_tile < 0) continue;
    Add(sample.kind, 1e3 * (sample.first_tile - sample.intended), &first_tile);
    Add(sample.kind, 1e3 * (sample.last_tile - sample.intended), &last_tile);
    for (const auto& [stage, milliseconds] : sample.stages) stages[stage].push_back(milliseconds);
  }
  report.offered_rate = Rate(static_cast<double>(report.offered), report.sending_seconds);
  report.achieved_rate = Rate(static_cast<double>(report.sent), report.seconds);
  report.good_rate = Rate(static_cast<double>(report.good), report.seconds);
  report.vertex_rate = Rate(vertices, report.seconds);
  report.byte_rate = Rate(bytes, report.seconds);
  report.latency = AllPercentiles(std::move(latency));
  report.first_tile = AllPercentiles(std::move(first_tile));
  report.last_tile = AllPercentiles(std::move(last_tile));
  report.stages = AllPercentiles(std::move(stages));
  return report;
}

std::string ReportText(const LoadReport& report) {
  std::string text = absl::StrFormat(
      "jobs           %d to be sent in %.1f s, %d sent (%d late), %d dropped, %d ended well\n"
      "rate           offered %.1f/s, achieved %.1f/s, good %.1f/s\n"
      "throughput     %.0f vertices/s, %.1f MB/s\n",
      report.offered, report.sending_seconds, report.sent, report.late, report.dropped, report.good,
      report.offered_rate, report.achieved_rate, report.good_rate, report.vertex_rate,
      report.byte_rate / 1e6);
  if (report.process.has_value()) {
    const ProcessUse& use = *report.process;
    const auto megabytes = [](std::uint64_t bytes) { return static_cast<double>(bytes) / 1e6; };
    absl::StrAppendFormat(
        &text, "server         %.0f MB before, %.0f MB at the peak, %.0f MB after; %.2f CPUs\n",
        megabytes(use.bytes_before), megabytes(use.bytes_peak), megabytes(use.bytes_after),
        Rate(use.cpu_seconds, report.seconds));
  }
  AppendTable("latency, ms", report.latency, &text);
  AppendTable("first tile, ms", report.first_tile, &text);
  AppendTable("last tile, ms", report.last_tile, &text);
  AppendTable("server stages, ms", report.stages, &text);
  absl::StrAppend(&text, "\nended\n");
  for (const auto& [outcome, count] : report.outcomes) {
    absl::StrAppendFormat(&text, "  %-40s %9d\n", outcome, count);
  }
  return text;
}

std::string ReportJson(const LoadReport& report) {
  JsonObject outcomes;
  for (const auto& [outcome, count] : report.outcomes) outcomes.Add(outcome, count);
  JsonObject object;
  object.AddNumber("sending_seconds", report.sending_seconds)
      .AddNumber("seconds", report.seconds)
      .Add("offered", report.offered)
      .Add("sent", report.sent)
      .Add("late", report.late)
      .Add("dropped", report.dropped)
      .Add("good", report.good)
      .AddNumber("offered_rate", report.offered_rate)
      .AddNumber("achieved_rate", report.achieved_rate)
      .AddNumber("good_rate", report.good_rate)
      .AddNumber("vertex_rate", report.vertex_rate)
      .AddNumber("byte_rate", report.byte_rate)
      .Add("latency", ToJson(report.latency))
      .Add("first_tile", ToJson(report.first_tile))
      .Add("last_tile", ToJson(report.last_tile))
      .Add("stages", ToJson(report.stages))
      .Add("outcomes", outcomes);
  if (report.process.has_value()) {
    object.Add("process", JsonObject()
                              .Add("bytes_before", report.process->bytes_before)
                              .Add("bytes_peak", report.process->bytes_peak)
                              .Add("bytes_after", report.process->bytes_after)
                              .AddNumber("cpu_seconds", report.process->cpu_seconds));
  }
  return object.Text() + "\n";
}

std::string SamplesCsv(const LoadResult& result) {
  std::string text =
      "kind,intended,sent,first_tile,last_tile,ended,outcome,good,bytes_sent,bytes_received\n";
  const auto time = [](double seconds) {
    return seconds < 0 ? std::string() : absl::StrFormat("%.6f", seconds);
  };
  for (const Sample& s : result.samples) {
    absl::StrAppend(&text, std::string(JobKindName(s.kind)), ",", time(s.intended), ",",
                    time(s.sent), ",", time(s.first_tile), ",", time(s.last_tile), ",",
                    time(s.ended), ",", s.outcome, ",", s.good ? 1 : 0, ",", s.bytes_sent, ",");
    absl::StrAppend(&text, s.bytes_received, "\n");
  }
  return text;
}

}  // namespace limn::load
