// SPDX-License-Identifier: MIT
// What a load test found: percentiles of latencies from the intended time of sending, rates, ends
// by reason, the server's stages; as text, JSON and CSV.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client/load/generator.h"
#include "client/load/process_probe.h"

namespace limn::load {

// Of all values, none of them rounded: the q-th percentile is the smallest value that at least
// q percent of them do not exceed (nearest rank).
struct Percentiles {
  std::uint64_t count = 0;
  double mean = 0;
  double p50 = 0;
  double p90 = 0;
  double p99 = 0;
  double p999 = 0;
  double max = 0;
};
[[nodiscard]] Percentiles PercentilesOf(std::vector<double> values);

// Times in milliseconds.
struct LoadReport {
  double sending_seconds = 0;
  double seconds = 0;
  std::uint64_t offered = 0;
  std::uint64_t sent = 0;
  std::uint64_t late = 0;
  std::uint64_t dropped = 0;
  // Jobs that ended as their kind is to.
  std::uint64_t good = 0;
  // Jobs per second: to be sent, over the time of sending; ended, and ended well, over all the
  // time.
  double offered_rate = 0;
  double achieved_rate = 0;
  double good_rate = 0;
  // Vertices of the meshes of jobs that ended well, and bytes both ways, per second.
  double vertex_rate = 0;
  double byte_rate = 0;
  // From the intended time to the end, and to the first and the last piece of the surface; of jobs
  // that ended well, by kind and, under "all", of small and large ones together.
  std::map<std::string, Percentiles> latency;
  std::map<std::string, Percentiles> first_tile;
  std::map<std::string, Percentiles> last_tile;
  // Jobs by kind and outcome: "small OK".
  std::map<std::string, std::uint64_t> outcomes;
  // Of the server, by its summaries.
  std::map<std::string, Percentiles> stages;
  std::optional<ProcessUse> process;
};

[[nodiscard]] LoadReport MakeReport(const LoadResult& result);

// For a person.
[[nodiscard]] std::string ReportText(const LoadReport& report);
// For a program; the names are those above.
[[nodiscard]] std::string ReportJson(const LoadReport& report);
// A line per job: kind, intended, sent, first_tile, last_tile, ended (seconds after the start;
// empty where there was none), outcome, good, bytes_sent, bytes_received.
[[nodiscard]] std::string SamplesCsv(const LoadResult& result);

// What a service promises: "p99=50,p99.9=200,first-tile-p99=20,errors=0.01,good-rate=95".
// Percentiles in milliseconds (p50, p90, p99, p99.9, max; also first-tile- and last-tile-), of
// small and large jobs together; errors: the share of jobs sent that did not end well, dropped ones
// among them; good-rate: jobs per second at the least.
struct Objective {
  std::string name;
  double bound = 0;
};
// Errors: INVALID_OPTION for what is not understood.
[[nodiscard]] absl::StatusOr<std::vector<Objective>> ParseObjectives(absl::string_view text);
// What is not kept, a sentence for each.
[[nodiscard]] std::vector<std::string> Violations(const std::vector<Objective>& objectives,
                                                  const LoadReport& report);

}  // namespace limn::load
