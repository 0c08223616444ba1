// SPDX-License-Identifier: MIT
// The engine's kernels against the bandwidth of the machine, and a whole job's memory against the
// arrays that it has to hold.
#pragma once

#include <string>
#include <vector>

#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {

struct Bandwidth {
  int threads = 1;
  // Bytes a second, by STREAM's counting: what a loop reads and writes.
  double copy = 0;
  double triad = 0;
  double best() const { return copy > triad ? copy : triad; }
};

struct KernelOutcome {
  std::string name;
  int threads = 1;
  std::uint64_t vertices = 0;
  double seconds = 0;
  // Each array that it reads or writes counted once.
  double bytes = 0;
  // Seconds over those that the bytes take at the bandwidth.
  double over_bound = 0;
};

struct KernelReport {
  std::vector<Bandwidth> bandwidth;
  std::vector<KernelOutcome> kernels;
};

// On a mesh of polygons and one of triangles, with one and two threads, kernels and STREAM's loops
// in turns.
KernelReport MeasureKernels(std::uint64_t vertices);

struct JobOutcome {
  std::string name;
  std::uint64_t vertices = 0;
  double seconds = 0;
  double peak_bytes = 0;
  // Of the result: control points and tessellation.
  double result_bytes = 0;
  // Of the result and of what the last stage makes it from.
  double held_bytes = 0;
};

// Interpolation with a tessellation and normals at level 2.
std::vector<JobOutcome> MeasureJobs(std::uint64_t vertices);

}  // namespace limn::comparison
