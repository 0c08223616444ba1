// SPDX-License-Identifier: MIT
// What the experiments share: where to write, models, time, files. All of them end the program with
// a message where the engine or the disk fails.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/polygon_mesh.h"
#include "tests/experiments/report.h"

namespace limn::experiments {

[[noreturn]] void Die(const absl::Status& status);
inline void OrDie(const absl::Status& status) {
  if (!status.ok()) Die(status);
}
template <class T>
T OrDie(absl::StatusOr<T> value) {
  if (!value.ok()) Die(value.status());
  return *std::move(value);
}

// What one run is told.
struct Setup {
  const Context context;
  // Existing folder to write to, and the one in it for what pictures are made of.
  std::string out;
  std::string scenes() const { return out + "/scenes"; }
  // The smaller size only, and everything timed once: to see that it works.
  bool quick = false;
};

// Sizes of the paper's two models [ZC section 3.5].
inline constexpr std::uint64_t kSmallModel = 562;
inline constexpr std::uint64_t kLargeModel = 11540;

struct Model {
  std::string name;
  PolygonMesh given;
  HalfEdgeMesh mesh;
  // Diagonal of the bounding box.
  double scale = 1;
};

// A generated mesh, seed 1.
Model MakeModel(const Setup& setup, MeshKind kind, std::uint64_t vertices);

// Milliseconds of the fastest of several runs of f(): as many as fit into a third of a second, at
// least three and at most 200; one in a quick run.
template <class F>
double BestMilliseconds(const Setup& setup, const F& f) {
  using Clock = std::chrono::steady_clock;
  using Duration = std::chrono::duration<double, std::milli>;
  double best = 0;
  double total = 0;
  const int most = setup.quick ? 1 : 200;
  for (int run = 0; run < most && (run < 3 || total < 333); ++run) {
    const Clock::time_point begin = Clock::now();
    f();
    const double elapsed = Duration(Clock::now() - begin).count();
    best = run == 0 ? elapsed : std::min(best, elapsed);
    total += elapsed;
  }
  return best;
}

// Writes text to a file in setup.out.
void WriteText(const Setup& setup, const std::string& name, const std::string& text);

}  // namespace limn::experiments
