// SPDX-License-Identifier: MIT
#include "client/load/sweep.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "engine/base/error.h"

namespace limn::load {
namespace {

std::vector<std::string> WhyNotKept(const std::vector<Objective>& objectives,
                                    const LoadReport& report) {
  std::vector<std::string> violations = Violations(objectives, report);
  const double good = static_cast<double>(report.good);
  if (good < 0.95 * static_cast<double>(report.offered)) {
    violations.push_back(
        absl::StrCat(report.good, " of ", report.offered, " jobs ended well, fewer than 95 %"));
  }
  if (report.seconds > 1.2 * report.sending_seconds) {
    violations.push_back(absl::StrFormat("the last job ended after %.1f s, sent within %.1f s",
                                         report.seconds, report.sending_seconds));
  }
  return violations;
}

}  // namespace

absl::StatusOr<SweepResult> FindKnee(const SweepOptions& options,
                                     const std::function<absl::StatusOr<LoadReport>(double)>& run) {
  SweepResult result;
  double broken = 0;
  const auto step = [&](double rate) -> absl::Status {
    LIMN_ASSIGN_OR_RETURN(LoadReport report, run(rate));
    std::vector<std::string> violations = WhyNotKept(options.objectives, report);
    (violations.empty() ? result.knee : broken) = rate;
    result.steps.push_back({rate, std::move(report), std::move(violations)});
    return absl::OkStatus();
  };
  double rate = options.first_rate;
  for (std::uint64_t i = 0; i < options.most_steps && broken == 0; ++i, rate *= options.factor) {
    LIMN_RETURN_IF_ERROR(step(rate));
  }
  for (std::uint64_t i = 0; i < options.bisections && broken > 0; ++i) {
    LIMN_RETURN_IF_ERROR(step((result.knee + broken) / 2));
  }
  return result;
}

std::string SweepText(const SweepResult& result) {
  std::string text = absl::StrFormat("%10s %10s %10s %10s %10s %10s  %s\n", "rate/s", "good/s",
                                     "p50 ms", "p99 ms", "p99.9 ms", "failed", "");
  for (const SweepStep& step : result.steps) {
    const auto all = step.report.latency.find("all");
    const Percentiles p = all == step.report.latency.end() ? Percentiles() : all->second;
    absl::StrAppendFormat(&text, "%10.1f %10.1f %10.2f %10.2f %10.2f %10d  %s\n", step.rate,
                          step.report.good_rate, p.p50, p.p99, p.p999,
                          step.report.offered - step.report.good,
                          step.violations.empty() ? "kept" : absl::StrJoin(step.violations, "; "));
  }
  if (result.knee > 0) {
    absl::StrAppendFormat(&text, "knee: %.1f jobs/s\n", result.knee);
  } else {
    absl::StrAppend(&text, "no rate was kept: begin with a lower one\n");
  }
  return text;
}

}  // namespace limn::load
