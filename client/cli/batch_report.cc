// SPDX-License-Identifier: MIT
#include "client/cli/batch_report.h"

#include <map>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/json_object.h"
#include "client/cli/report.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

using State = BatchOutcome::State;

std::string Row(std::string_view name, const std::string& value) {
  return absl::StrFormat("%-22s %s\n", name, value);
}

std::string_view StateName(State state) {
  switch (state) {
    case State::kSucceeded:
      return "succeeded";
    case State::kFailed:
      return "failed";
    case State::kSkipped:
      return "skipped";
    case State::kLeft:
      break;
  }
  return "left";
}

double JobsPerSecond(const BatchCounts& counts, double seconds) {
  const auto jobs = static_cast<double>(counts.succeeded + counts.failed);
  return seconds > 0 ? jobs / seconds : 0;
}

std::uint64_t Sum(const std::vector<BatchOutcome>& outcomes,
                  std::uint64_t BatchOutcome::*vertices) {
  std::uint64_t sum = 0;
  for (const BatchOutcome& outcome : outcomes) sum += outcome.*vertices;
  return sum;
}

JsonObject JobJson(const BatchEntry& entry, const BatchOutcome& outcome) {
  JsonObject job;
  job.Add("id", entry.id).Add("input", entry.input).Add("status", StateName(outcome.state));
  if (outcome.state == State::kFailed) {
    job.Add("reason", outcome.reason).Add("message", outcome.message);
  }
  if (outcome.tries > 0) job.Add("tries", outcome.tries).AddNumber("seconds", outcome.seconds);
  if (outcome.state == State::kSucceeded) {
    job.Add("givenVertices", outcome.given_vertices);
    job.Add("surfaceVertices", outcome.surface_vertices);
  }
  return job;
}

}  // namespace

BatchCounts CountOutcomes(const std::vector<BatchOutcome>& outcomes) {
  BatchCounts counts;
  for (const BatchOutcome& outcome : outcomes) {
    switch (outcome.state) {
      case State::kSucceeded:
        ++counts.succeeded;
        break;
      case State::kFailed:
        ++counts.failed;
        break;
      case State::kSkipped:
        ++counts.skipped;
        break;
      case State::kLeft:
        ++counts.left;
    }
  }
  return counts;
}

std::string ReasonOf(const absl::Status& status) {
  const auto detail = GetErrorDetail(status);
  // What is no error of Limn's at all counts as a defect of it there.
  if (detail.has_value() &&
      (detail->reason != Reason::kInternal || status.code() == absl::StatusCode::kInternal)) {
    return std::string(ReasonName(detail->reason));
  }
  return absl::StatusCodeToString(status.code());
}

std::string BatchTable(const std::vector<BatchOutcome>& outcomes, double seconds) {
  const BatchCounts counts = CountOutcomes(outcomes);
  std::string table = Row("jobs", WithCommas(outcomes.size()));
  table += Row("succeeded", WithCommas(counts.succeeded));
  if (counts.skipped > 0) table += Row("skipped, done before", WithCommas(counts.skipped));
  table += Row("failed", WithCommas(counts.failed));
  std::map<std::string, std::uint64_t> reasons;
  for (const BatchOutcome& outcome : outcomes) {
    if (outcome.state == State::kFailed) ++reasons[outcome.reason];
  }
  for (const auto& [reason, count] : reasons) {
    table += Row("", absl::StrCat(reason, ": ", WithCommas(count)));
  }
  if (counts.left > 0) table += Row("left", WithCommas(counts.left));
  table += Row("given vertices", WithCommas(Sum(outcomes, &BatchOutcome::given_vertices)));
  table += Row("surface vertices", WithCommas(Sum(outcomes, &BatchOutcome::surface_vertices)));
  table += Row("time", absl::StrFormat("%.3f s", seconds));
  return table + Row("jobs per second", absl::StrFormat("%.1f", JobsPerSecond(counts, seconds)));
}

std::string BatchJson(const std::vector<BatchEntry>& entries,
                      const std::vector<BatchOutcome>& outcomes, double seconds) {
  const BatchCounts counts = CountOutcomes(outcomes);
  std::vector<JsonObject> jobs;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    jobs.push_back(JobJson(entries[i], outcomes[i]));
  }
  JsonObject report;
  report.Add("jobs", entries.size()).Add("succeeded", counts.succeeded);
  report.Add("failed", counts.failed).Add("skipped", counts.skipped).Add("left", counts.left);
  report.Add("givenVertices", Sum(outcomes, &BatchOutcome::given_vertices));
  report.Add("surfaceVertices", Sum(outcomes, &BatchOutcome::surface_vertices));
  report.AddNumber("seconds", seconds).AddNumber("jobsPerSecond", JobsPerSecond(counts, seconds));
  return report.Add("results", jobs).Text() + "\n";
}

}  // namespace limn::cli
