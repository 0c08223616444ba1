// SPDX-License-Identifier: MIT
// What Limn wants to be, as bounds of measured ratios.
#pragma once

#include <string>
#include <vector>

#include "tests/benchmarks/comparison/kernels.h"
#include "tests/benchmarks/comparison/measure.h"

namespace limn::comparison {

struct Report {
  std::vector<Cell> cells;
  KernelReport kernels;
  std::vector<JobOutcome> jobs;
};

// "Limn is at least this many times as fast as the fastest such rival", or 0 where there is no such
// goal.
double GoalFactor(Task task, const std::string& rival);

// The fastest of a cell's rivals of that name, of one thread or (limn = 1) of any; null if there is
// none with figures. limn: index into Outcome::over_limn.
const Outcome* Fastest(const Cell& cell, const std::string& rival, std::size_t limn);

struct Verdict {
  std::string goal;
  // Where it was looked at, and what was found.
  std::string found;
  // Of so many, so many were as wanted.
  int looked_at = 0;
  int met = 0;
};

std::vector<Verdict> JudgeGoals(const Report& report);

}  // namespace limn::comparison
