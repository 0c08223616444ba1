// SPDX-License-Identifier: MIT
// Finds the knee of a server: the highest rate at which it still keeps its promises.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/load/load_report.h"

namespace limn::load {

struct SweepOptions {
  // Jobs per second of the first step, above 0.
  double first_rate = 10;
  // From one step to the next while all is kept, above 1.
  double factor = 1.5;
  // Steps at the most while the rate rises.
  std::uint64_t most_steps = 24;
  // Steps between the last rate that was kept and the first that was not.
  std::uint64_t bisections = 3;
  std::vector<Objective> objectives = {};
};

struct SweepStep {
  double rate = 0;
  LoadReport report;
  // Why the rate is not kept; none: it is. Beside the objectives: fewer than 95 % of the jobs to be
  // sent ended well, or it took more than a fifth longer than they were sent for.
  std::vector<std::string> violations;
};

struct SweepResult {
  // In the order in which they were run.
  std::vector<SweepStep> steps;
  // The highest rate that was kept; 0: none was.
  double knee = 0;
};

// run: puts the load on the server at that rate. Its first error is returned.
[[nodiscard]] absl::StatusOr<SweepResult> FindKnee(
    const SweepOptions& options, const std::function<absl::StatusOr<LoadReport>(double)>& run);

// A table of the steps, and the knee.
[[nodiscard]] std::string SweepText(const SweepResult& result);

}  // namespace limn::load
