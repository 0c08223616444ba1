// SPDX-License-Identifier: MIT
// What a service promises, and whether a load test found it kept.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "client/load/load_report.h"
#include "engine/base/error.h"

namespace limn::load {
namespace {

constexpr std::array kPercentiles = {
    std::pair("p50", &Percentiles::p50), std::pair("p90", &Percentiles::p90),
    std::pair("p99", &Percentiles::p99), std::pair("p99.9", &Percentiles::p999),
    std::pair("max", &Percentiles::max)};

// The percentile that the rest of a name says; null for none.
double Percentiles::*Named(absl::string_view name) {
  for (const auto& [known, member] : kPercentiles) {
    if (name == known) return member;
  }
  return nullptr;
}

absl::string_view WithoutPrefix(absl::string_view name) {
  if (!absl::ConsumePrefix(&name, "first-tile-")) (void)absl::ConsumePrefix(&name, "last-tile-");
  return name;
}

bool IsKnown(absl::string_view name) {
  return name == "errors" || name == "good-rate" || Named(WithoutPrefix(name)) != nullptr;
}

// NaN where there is nothing to tell of, which keeps no promise.
double Found(const std::string& name, const LoadReport& report) {
  if (name == "good-rate") return report.good_rate;
  if (name == "errors") {
    const double all = static_cast<double>(report.sent + report.dropped);
    return all > 0 ? 1 - static_cast<double>(report.good) / all : std::nan("");
  }
  const auto& table = absl::StartsWith(name, "first-")  ? report.first_tile
                      : absl::StartsWith(name, "last-") ? report.last_tile
                                                        : report.latency;
  const auto all = table.find("all");
  return all == table.end() ? std::nan("") : all->second.*Named(WithoutPrefix(name));
}

}  // namespace

absl::StatusOr<std::vector<Objective>> ParseObjectives(absl::string_view text) {
  std::vector<Objective> objectives;
  for (const absl::string_view part : absl::StrSplit(text, ',')) {
    const std::pair<absl::string_view, absl::string_view> pair = absl::StrSplit(part, '=');
    double bound = 0;
    if (!IsKnown(pair.first) || !absl::SimpleAtod(pair.second, &bound) || !(bound >= 0)) {
      return MakeError(absl::StrCat("'", part, "' is no objective"),
                       {.reason = Reason::kInvalidOption,
                        .field = "slo",
                        .remedy = "Write it as p99=50,errors=0.01; names are p50, p90, p99, p99.9 "
                                  "and max, also after first-tile- and last-tile-, errors and "
                                  "good-rate"});
    }
    objectives.push_back({std::string(pair.first), bound});
  }
  return objectives;
}

std::vector<std::string> Violations(const std::vector<Objective>& objectives,
                                    const LoadReport& report) {
  std::vector<std::string> violations;
  for (const auto& [name, bound] : objectives) {
    const double found = Found(name, report);
    const bool kept = name == "good-rate" ? found >= bound : found <= bound;
    if (kept) continue;
    violations.push_back(absl::StrCat(name, " is ", found, ", not ", bound,
                                      name == "good-rate" ? " or more" : " or less"));
  }
  return violations;
}

}  // namespace limn::load
