// SPDX-License-Identifier: MIT
#include "tests/benchmarks/comparison/measure.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <sstream>

#include "tests/benchmarks/comparison/agreement.h"

namespace limn::comparison {
namespace {

constexpr int kMostRounds = 15;
// Runs shorter than this are repeated and averaged within a round.
constexpr double kShortest = 1e-3;

class Player {
 public:
  Player(const Entry& entry, const PolygonMesh& mesh) : contestant_(entry.make(mesh)) {}

  // Seconds for one run, the mean of so many.
  Instant Time(int runs) {
    Instant seconds;
    for (int i = 0; i < runs; ++i) {
      contestant_->Prepare();
      const Instant begin = Now();
      contestant_->Run();
      const Instant end = Now();
      seconds.clock += (end.clock - begin.clock) / runs;
      seconds.processor += (end.processor - begin.processor) / runs;
    }
    return seconds;
  }
  Answer GetAnswer() { return contestant_->GetAnswer(); }

  int rounds = 0;
  int repeats = 1;

 private:
  std::unique_ptr<Contestant> contestant_;
};

bool IsSolve(Task task) { return task == Task::kSolve6 || task == Task::kSolve12; }

// Writes lines "answer ENTRY POINTS NORMALS", "failed ENTRY WHY" and "time ENTRY CLOCK PROCESSOR",
// the latter round by round.
void TakeTurns(Task task, const std::vector<Entry>& entries, const std::vector<bool>& taking_part,
               const PolygonMesh& mesh, double budget, std::FILE* out) {
  std::vector<std::unique_ptr<Player>> players(entries.size());
  Fingerprint reference;
  if (IsSolve(task)) reference = Fingerprint(ExactSolution(mesh));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!taking_part[i]) continue;
    try {
      auto player = std::make_unique<Player>(entries[i], mesh);
      // The first run warms up and shows how long it takes.
      const double first = player->Time(1).clock;
      const Fingerprint found(player->GetAnswer());
      if (i == 0 && !IsSolve(task)) reference = found;
      const Difference difference = found.From(reference);
      std::fprintf(out, "answer %zu %.17g %.17g\n", i, difference.points, difference.normals);
      player->repeats = std::max(1, static_cast<int>(kShortest / first));
      const int least = first > 5 * budget ? 1 : 3;
      player->rounds =
          std::clamp(static_cast<int>(budget / (first * player->repeats)), least, kMostRounds);
      players[i] = std::move(player);
    } catch (const std::exception& error) {
      std::fprintf(out, "failed %zu %s\n", i, error.what());
    }
  }
  int rounds = 0;
  for (const auto& player : players) {
    if (player != nullptr) rounds = std::max(rounds, player->rounds);
  }
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t j = 0; j < players.size(); ++j) {
      // There and back.
      const std::size_t i = round % 2 == 0 ? j : players.size() - 1 - j;
      Player* const player = players[i].get();
      // Limn is in every round, to be compared with.
      if (player == nullptr || (round >= player->rounds && !entries[i].rival.empty())) continue;
      const Instant time = player->Time(player->repeats);
      std::fprintf(out, "time %zu %.17g %.17g\n", i, time.clock, time.processor);
    }
  }
}

// By entry and round.
using Times = std::vector<std::vector<Instant>>;

double MedianOf(const std::vector<Instant>& times, double Instant::*clock) {
  std::vector<double> values;
  for (const Instant& time : times) values.push_back(time.*clock);
  return Median(values);
}

void Parse(const std::string& text, const std::vector<Entry>& entries, Cell* cell, Times* times) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    std::size_t i = 0;
    words >> kind >> i;
    if (kind == "crashed") {
      for (Outcome& outcome : cell->outcomes) {
        if (outcome.missing.empty()) outcome.missing = "crashed";
      }
      return;
    }
    Outcome& outcome = cell->outcomes.at(i);
    if (kind == "failed") {
      std::getline(words, outcome.missing);
    } else if (kind == "answer") {
      words >> outcome.point_difference >> outcome.normal_difference;
      outcome.agrees = outcome.point_difference <= entries[i].agreement;
    } else if (kind == "time") {
      Instant time;
      words >> time.clock >> time.processor;
      (*times)[i].push_back(time);
    }
  }
}

void FillMedians(const Times& times, Cell* cell) {
  for (std::size_t i = 0; i < cell->outcomes.size(); ++i) {
    Outcome& outcome = cell->outcomes[i];
    if (!outcome.missing.empty()) continue;
    outcome.seconds = MedianOf(times[i], &Instant::clock);
    outcome.processor_seconds = MedianOf(times[i], &Instant::processor);
    outcome.rounds = static_cast<int>(times[i].size());
    for (std::size_t limn = 0; limn < 2; ++limn) {
      const bool one_thread = limn == 0 && outcome.threads == 1;
      double Instant::*const clock = one_thread ? &Instant::processor : &Instant::clock;
      std::vector<double> ratios;
      for (std::size_t r = 0; r < std::min(times[i].size(), times[limn].size()); ++r) {
        ratios.push_back(times[i][r].*clock / times[limn][r].*clock);
      }
      outcome.over_limn[limn] = Median(ratios);
    }
  }
}

double FindPeak(const Entry& entry, const PolygonMesh& mesh) {
  const std::string text = InChild([&](std::FILE* out) {
    const std::unique_ptr<Contestant> contestant = entry.make(mesh);
    contestant->Prepare();
    std::fprintf(out, "%.17g\n", PeakBytes([&] { contestant->Run(); }));
  });
  return std::strtod(text.c_str(), nullptr);
}

// How the time of a contestant grows with the mesh, to the safe side.
double Growth(const Entry& entry) { return entry.rival == "direct" ? 1.5 : 1.1; }

}  // namespace

Cell Measure(Task task, Meshes meshes, const PolygonMesh& mesh, const MeasureOptions& options,
             const Cell* before) {
  const std::vector<Entry> entries = AllEntries(task);
  Cell cell = {task, meshes, mesh.vertex_count(), {}};
  std::vector<bool> taking_part(entries.size(), true);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Entry& entry = entries[i];
    Outcome outcome = {.name = entry.name, .rival = entry.rival, .threads = entry.threads};
    if (before != nullptr) {
      const Outcome& earlier = before->outcomes[i];
      const double growth =
          static_cast<double>(cell.vertices) / static_cast<double>(before->vertices);
      const double expected = earlier.seconds * std::pow(growth, Growth(entry));
      if (!earlier.missing.empty() || expected > options.patience) {
        outcome.missing = earlier.missing.empty() ? "too slow" : earlier.missing;
        taking_part[i] = false;
      }
    }
    cell.outcomes.push_back(std::move(outcome));
  }
  Times times(entries.size());
  Parse(InChild([&](std::FILE* out) {
          TakeTurns(task, entries, taking_part, mesh, options.budget, out);
        }),
        entries, &cell, &times);
  FillMedians(times, &cell);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    // Memory does not depend on threads.
    if (entries[i].threads == 1 && cell.outcomes[i].missing.empty()) {
      cell.outcomes[i].peak_bytes = FindPeak(entries[i], mesh);
    }
  }
  return cell;
}

}  // namespace limn::comparison
