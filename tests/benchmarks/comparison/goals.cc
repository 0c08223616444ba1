// SPDX-License-Identifier: MIT
#include "tests/benchmarks/comparison/goals.h"

#include <algorithm>
#include <limits>

#include "absl/strings/str_format.h"

namespace limn::comparison {
namespace {

struct RivalGoal {
  std::vector<Task> tasks;
  const char* rival;
  double factor;
  const char* text;
};

const std::vector<RivalGoal>& RivalGoals() {
  static const std::vector<RivalGoal> kGoals = {
      {{Task::kSolve6}, "direct", 50, "solve to 1e-6 over the fastest direct solver"},
      {{Task::kSolve6}, "iterative", 8, "solve to 1e-6 over the fastest iterative solver"},
      {{Task::kDooSabinStep}, "CGAL", 30, "Doo-Sabin step with connectivity over CGAL"},
      {{Task::kCatmullClark}, "OpenSubdiv", 8, "Catmull-Clark from index arrays over OpenSubdiv"},
      {{Task::kLoop}, "OpenSubdiv", 8, "Loop from index arrays over OpenSubdiv"},
      {{Task::kCatmullClarkLimit}, "Bfr", 30, "Catmull-Clark limit with normals over Bfr"},
      {{Task::kLoopLimit}, "Bfr", 30, "Loop limit with normals over Bfr"},
      {{Task::kBuild}, "OpenMesh", 6, "half-edge build over OpenMesh"},
  };
  return kGoals;
}

bool Contains(const std::vector<Task>& tasks, Task task) {
  return std::find(tasks.begin(), tasks.end(), task) != tasks.end();
}

// Collects figures and how many of them are as wanted.
class Range {
 public:
  void Add(double value, bool met) {
    least_ = std::min(least_, value);
    most_ = std::max(most_, value);
    ++looked_at_;
    if (met) ++met_;
  }
  Verdict Say(std::string goal, const char* unit) const {
    Verdict verdict = {std::move(goal), "not measured", looked_at_, met_};
    if (looked_at_ > 0) verdict.found = absl::StrFormat("%.3g to %.3g%s", least_, most_, unit);
    return verdict;
  }

 private:
  double least_ = std::numeric_limits<double>::infinity();
  double most_ = -std::numeric_limits<double>::infinity();
  int looked_at_ = 0;
  int met_ = 0;
};

void JudgeRivals(const Report& report, std::vector<Verdict>* verdicts) {
  for (const RivalGoal& goal : RivalGoals()) {
    for (const std::size_t limn : {0, 1}) {
      Range range;
      for (const Cell& cell : report.cells) {
        if (!Contains(goal.tasks, cell.task)) continue;
        const Outcome* const rival = Fastest(cell, goal.rival, limn);
        if (rival == nullptr) continue;
        range.Add(rival->over_limn[limn], rival->over_limn[limn] >= goal.factor);
      }
      verdicts->push_back(range.Say(absl::StrFormat("%s: %g times, %s", goal.text, goal.factor,
                                                    limn == 0 ? "one thread" : "two threads"),
                                    " times"));
    }
  }
}

// The steps with connectivity of polygons at two sizes, as a half-edge prototype did them with all
// memory there from before.
void JudgeSteps(const Report& report, std::vector<Verdict>* verdicts) {
  constexpr std::pair<std::uint64_t, double> kFigures[] = {{11'540, 0.48}, {1'000'000, 79}};
  for (const auto& [vertices, milliseconds] : kFigures) {
    Range range;
    for (const Cell& cell : report.cells) {
      if (cell.task != Task::kCatmullClarkStep || cell.meshes != Meshes::kPolygons) continue;
      if (cell.vertices != vertices || !cell.outcomes[0].missing.empty()) continue;
      const double found = 1e3 * cell.outcomes[0].processor_seconds;
      range.Add(found, found <= milliseconds);
    }
    verdicts->push_back(range.Say(
        absl::StrFormat("Catmull-Clark step with connectivity, %d polygon vertices, one thread: "
                        "%g ms at the most",
                        vertices, milliseconds),
        " ms"));
  }
}

void JudgeKernels(const Report& report, std::vector<Verdict>* verdicts) {
  Range bound;
  Range sweep;
  for (const KernelOutcome& kernel : report.kernels.kernels) {
    if (kernel.vertices < 1'000'000) continue;
    bound.Add(kernel.over_bound, kernel.over_bound <= 1.5);
    if (kernel.name != "Chebyshev sweep" || kernel.threads != 1) continue;
    const double found = 1e9 * kernel.seconds / static_cast<double>(kernel.vertices);
    sweep.Add(found, found <= 8);
  }
  verdicts->push_back(bound.Say(
      "kernels at a million vertices: 1.5 times bytes / bandwidth at the most", " times"));
  verdicts->push_back(
      sweep.Say("sweep at a million vertices, one thread: 8 ns at the most", " ns"));
}

void JudgeThreads(const Report& report, std::vector<Verdict>* verdicts) {
  for (const TaskInfo& task : AllTasks()) {
    Range range;
    for (const Cell& cell : report.cells) {
      if (cell.task != task.task || cell.vertices < 90'000) continue;
      if (!cell.outcomes[0].missing.empty()) continue;
      range.Add(cell.outcomes[0].over_limn[1], cell.outcomes[0].over_limn[1] >= 1.8);
    }
    verdicts->push_back(range.Say(
        absl::StrFormat("%s: two threads 1.8 times one, from 100,000 vertices up", task.name),
        " times"));
  }
}

}  // namespace

double GoalFactor(Task task, const std::string& rival) {
  for (const RivalGoal& goal : RivalGoals()) {
    if (Contains(goal.tasks, task) && rival == goal.rival) return goal.factor;
  }
  return 0;
}

const Outcome* Fastest(const Cell& cell, const std::string& rival, std::size_t limn) {
  const Outcome* fastest = nullptr;
  for (const Outcome& outcome : cell.outcomes) {
    if (outcome.rival != rival || !outcome.missing.empty() || outcome.seconds <= 0) continue;
    if (limn == 0 && outcome.threads != 1) continue;
    if (fastest == nullptr || outcome.seconds < fastest->seconds) fastest = &outcome;
  }
  return fastest;
}

std::vector<Verdict> JudgeGoals(const Report& report) {
  std::vector<Verdict> verdicts;
  JudgeRivals(report, &verdicts);
  JudgeSteps(report, &verdicts);
  JudgeKernels(report, &verdicts);
  JudgeThreads(report, &verdicts);
  Range memory;
  for (const JobOutcome& job : report.jobs) {
    const double found = job.peak_bytes / job.held_bytes;
    memory.Add(found, found <= 1.3);
  }
  verdicts.push_back(
      memory.Say("peak memory of a job: 1.3 times the arrays it must hold at the most", " times"));
  return verdicts;
}

}  // namespace limn::comparison
