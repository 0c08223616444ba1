// SPDX-License-Identifier: MIT
// Measures a task on one mesh. Everything runs in child processes: one in which all contestants
// take turns, so that whatever else the machine does hits them alike, and one for each contestant's
// peak memory.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine/mesh/polygon_mesh.h"
#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {

struct MeasureOptions {
  // Seconds that a contestant gets, but at least three rounds (one, if it takes longer than this
  // five times over).
  double budget = 0.6;
  // Contestants that would take longer for one run, by their time on the mesh before, are left out.
  double patience = 20;
};

struct Outcome {
  std::string name;
  std::string rival;
  int threads = 1;
  // Why there are no figures; empty if there are.
  std::string missing;
  // Medians over the rounds: of times by the clock, of processor times, and of ratios to Limn's
  // with one and with two threads in the same round. Ratios of one thread to one thread are of
  // processor times, which whatever else runs on the machine lengthens less; all others by the
  // clock.
  double seconds = 0;
  double processor_seconds = 0;
  double over_limn[2] = {0, 0};
  int rounds = 0;
  // Largest part of the bounding box, and largest difference of normals, by which the answer is
  // not that of Limn (of solvers: not the solution).
  double point_difference = 0;
  double normal_difference = 0;
  bool agrees = true;
  // Most resident memory of the work beyond what was there before it, result included.
  double peak_bytes = 0;
};

struct Cell {
  Task task;
  Meshes meshes;
  std::uint64_t vertices = 0;
  std::vector<Outcome> outcomes;
};

// before: the cell of the next smaller mesh, or null.
Cell Measure(Task task, Meshes meshes, const PolygonMesh& mesh, const MeasureOptions& options,
             const Cell* before);

// Runs work in a child process and returns what it has written. If it ends badly, a line
// "crashed" comes last.
std::string InChild(const std::function<void(std::FILE* out)>& work);

// Most resident bytes of this process while work runs, beyond those before.
double PeakBytes(const std::function<void()>& work);

double Median(std::vector<double> values);

// Seconds by the steady clock, and seconds of processor time of this process.
struct Instant {
  double clock = 0;
  double processor = 0;
};
Instant Now();

}  // namespace limn::comparison
