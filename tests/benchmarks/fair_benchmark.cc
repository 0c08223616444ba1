// SPDX-License-Identifier: MIT
// Time and effect of fairing, and time of the bound that chooses a level, on meshes of every closed
// kind. Run:
//   build/release/bin/fair_benchmark
//   build/release/bin/fair_benchmark --benchmark_filter=Fair/graded_box
// Arguments: vertices and threads. Counters: ns_per_vertex; energy, that of the surface as it comes
// (engine/limit/bending_energy.h); left, the part of it that fairing leaves; bound2 and bound6, of
// the distance at levels 2 and 6 over the bounding box's diagonal.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/parallel.h"
#include "engine/constraints/fair.h"
#include "engine/constraints/perturb.h"
#include "engine/limit/bending_energy.h"
#include "engine/limit/chord_bound.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/validate.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/solve/solve.h"
#include "engine/stencil/limit_stencil.h"

namespace limn {
namespace {

template <class T>
T OrDie(absl::StatusOr<T> value) {
  if (!value.ok()) std::abort();
  return *std::move(value);
}
void OrDie(const absl::Status& status) {
  if (!status.ok()) std::abort();
}

struct Input {
  Input(MeshKind kind, std::uint64_t vertices)
      : given(OrDie(GenerateMesh({.kind = kind, .vertices = vertices}))),
        surface{.mesh = OrDie(HalfEdgeMesh::Build(context, given)), .corners = {}, .boundary = {}} {
    OrDie(ValidatePositions(context, given.positions, &box));
    const LimitStencil stencil = DooSabinModifiedStencil();
    Buffer<Vec3> control(given.vertex_count());
    OrDie(Solve(context,
                {.mesh = surface.mesh,
                 .stencil = stencil,
                 .points = given.positions,
                 .scale = box.diagonal()},
                {}, absl::MakeSpan(control))
              .status());
    surface.corners.resize(surface.mesh.half_edge_count());
    OrDie(FirstRefinement(context, surface.mesh, control, absl::MakeSpan(surface.corners)));
    OrDie(PerturbToInterpolate(context, {surface.mesh, given.positions},
                               absl::MakeSpan(surface.corners)));
  }

  const Context context;
  const PolygonMesh given;
  BoundingBox box;
  DooSabinSurface surface;
};

// Runs body(input) in as many threads as the second argument says.
template <class Body>
void Measure(benchmark::State& state, MeshKind kind, const Body& body) {
  const Input input(kind, static_cast<std::uint64_t>(state.range(0)));
  ThreadArena arena(static_cast<int>(state.range(1)));
  arena.Execute([&] {
    for (auto _ : state) body(input);
  });
  state.counters["ns_per_vertex"] = benchmark::Counter(
      1e-9 * static_cast<double>(input.given.vertex_count()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void BM_BendingEnergy(benchmark::State& state, MeshKind kind) {
  Measure(state, kind, [&](const Input& input) {
    state.counters["energy"] = OrDie(BendingEnergy(input.context, input.surface));
  });
}

void BM_Fair(benchmark::State& state, MeshKind kind) {
  Measure(state, kind, [&](const Input& input) {
    DooSabinSurface surface = input.surface;
    const FairnessReport report = OrDie(Fair(input.context, {}, &surface));
    state.counters["energy"] = report.energy_before;
    state.counters["left"] = report.energy_after / report.energy_before;
  });
}

void BM_ChordBounds(benchmark::State& state, MeshKind kind) {
  Measure(state, kind, [&](const Input& input) {
    const std::vector<double> bounds = OrDie(ChordBounds(input.context, input.surface, 6));
    state.counters["bound2"] = bounds[2] / input.box.diagonal();
    state.counters["bound6"] = bounds[6] / input.box.diagonal();
  });
}

void Register() {
  const std::vector<std::pair<std::string, void (*)(benchmark::State&, MeshKind)>> all = {
      {"BendingEnergy", BM_BendingEnergy}, {"Fair", BM_Fair}, {"ChordBounds", BM_ChordBounds}};
  for (const auto& [name, function] : all) {
    for (const MeshKind kind : AllMeshKinds()) {
      if (!IsClosedKind(kind)) continue;
      const std::string full = name + "/" + std::string(MeshKindName(kind));
      benchmark::RegisterBenchmark(full.c_str(), function, kind)
          ->ArgsProduct({{11540}, {1, 2}})
          ->ArgNames({"vertices", "threads"})
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace limn

int main(int argc, char** argv) {
  limn::Register();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
