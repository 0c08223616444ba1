// SPDX-License-Identifier: MIT
// Time to find the auxiliary mesh: Limn's iterations beside the direct solvers of Eigen, for the
// modified first step and for Nasri's method, on one thread. Run:
//   build/release/bin/direct_solve_benchmark
//   build/release/bin/direct_solve_benchmark --benchmark_filter=/562 --benchmark_repetitions=5
// Argument: vertices (irregular sphere, polygons of 3 to 8 sides). Direct solvers assemble the
// matrix, factorise it and solve for three coordinates; the dense one only the small mesh.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/parallel.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/validate.h"
#include "engine/solve/solve.h"
#include "tests/experiments/direct_solve.h"

namespace limn {
namespace {

using experiments::DirectMethod;

template <class T>
T OrDie(absl::StatusOr<T> value) {
  if (!value.ok()) std::abort();
  return *std::move(value);
}

struct Input {
  explicit Input(std::uint64_t vertices)
      : given(OrDie(GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices}))),
        mesh(OrDie(HalfEdgeMesh::Build(context, given))),
        control(given.positions) {
    if (!ValidatePositions(context, given.positions, &box).ok()) std::abort();
  }

  const Context context;
  const PolygonMesh given;
  const HalfEdgeMesh mesh;
  Buffer<Vec3> control;
  BoundingBox box;
};

void Iterate(benchmark::State& state, const LimitStencil& stencil, const SolveOptions& options) {
  Input input(static_cast<std::uint64_t>(state.range(0)));
  ThreadArena(1).Execute([&] {
    for (auto _ : state) {
      const SolveReport report = OrDie(Solve(input.context,
                                             {.mesh = input.mesh,
                                              .stencil = stencil,
                                              .points = input.given.positions,
                                              .scale = input.box.diagonal()},
                                             options, absl::MakeSpan(input.control)));
      state.counters["sweeps"] = report.sweeps;
    }
  });
}

void SolveInOneGo(benchmark::State& state, const LimitStencil& stencil, DirectMethod method) {
  const Input input(static_cast<std::uint64_t>(state.range(0)));
  for (auto _ : state) {
    const experiments::DirectSolution solution =
        experiments::SolveDirectly(method, experiments::LimitMatrix(input.mesh, stencil),
                                   experiments::RightSide(input.mesh, input.given.positions));
    benchmark::DoNotOptimize(solution.x.data());
    state.counters["factor_size"] = static_cast<double>(solution.factor_size);
  }
}

// Each solver for both rules.
void Register(const std::string& rule, const LimitStencil& stencil) {
  for (const std::int64_t vertices : {562, 11540}) {
    const auto add = [&](const char* name, const auto& function) {
      benchmark::RegisterBenchmark(absl::StrCat(rule, "/", name).c_str(), function)
          ->Arg(vertices)
          ->Unit(benchmark::kMillisecond);
    };
    add("Limn_3e-3",
        [=](benchmark::State& state) { Iterate(state, stencil, {.tolerance = 0.003}); });
    add("Limn_1e-12",
        [=](benchmark::State& state) { Iterate(state, stencil, {.tolerance = 1e-12}); });
    add("SparseLdlt",
        [=](benchmark::State& state) { SolveInOneGo(state, stencil, DirectMethod::kSparseLdlt); });
    add("SparseLu",
        [=](benchmark::State& state) { SolveInOneGo(state, stencil, DirectMethod::kSparseLu); });
    // A gigabyte for the larger mesh.
    if (vertices > 1000) continue;
    add("Dense",
        [=](benchmark::State& state) { SolveInOneGo(state, stencil, DirectMethod::kDense); });
  }
}

}  // namespace
}  // namespace limn

int main(int argc, char** argv) {
  limn::Register("Modified", limn::DooSabinModifiedStencil());
  limn::Register("Nasri", limn::DooSabinStandardStencil());
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
