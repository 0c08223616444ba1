// SPDX-License-Identifier: MIT
// Time of each stage of an interpolation, in nanoseconds per vertex of the input (refinement and
// limit: also per point that they write). Run:
//   build/release/bin/engine_benchmark
//   build/release/bin/engine_benchmark --benchmark_filter=Sweep --benchmark_repetitions=5
// Arguments: vertices (irregular sphere, polygons of 3 to 8 sides) and threads.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <utility>
#include <vector>

#include "engine/base/heap.h"
#include "engine/base/parallel.h"
#include "engine/constraints/features.h"
#include "engine/constraints/perturb.h"
#include "engine/interpolate.h"
#include "engine/limit/doo_sabin_limit.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/validate.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/solve/solve.h"
#include "engine/stencil/limit_operator.h"

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

// Everything that the stages start from, made once per size.
struct Input {
  explicit Input(std::uint64_t vertices)
      : given(OrDie(GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices}))),
        mesh(OrDie(HalfEdgeMesh::Build(context, given))),
        split(OrDie(SplitIntoQuads(context, mesh))),
        fans(OrDie(FindExtraordinaryFans(context, mesh))),
        control(given.positions),
        first(mesh.half_edge_count()),
        second(split.half_edge_count()) {
    OrDie(ValidatePositions(context, given.positions, &box));
    OrDie(FirstRefinement(context, mesh, control, absl::MakeSpan(first)));
    OrDie(RefineDooSabin(context, {.mesh = mesh, .fans = fans, .k = 1}, first,
                         absl::MakeSpan(second)));
  }

  const Context context;
  const PolygonMesh given;
  const HalfEdgeMesh mesh;
  const HalfEdgeMesh split;
  const ExtraordinaryFans fans;
  const LimitStencil stencil = DooSabinModifiedStencil();
  Buffer<Vec3> control;
  Buffer<Vec3> first;
  Buffer<Vec3> second;
  BoundingBox box;
};

// The latest size is kept: a million vertices take a second to make.
Input& InputOf(std::uint64_t vertices) {
  static std::uint64_t kept = 0;
  static std::unique_ptr<Input> input;
  if (kept != vertices) {
    input.reset();
    input = std::make_unique<Input>(vertices);
    kept = vertices;
  }
  return *input;
}

// Runs body(input) in an arena of the wanted threads. written: points that it writes, if it is
// their number that counts.
template <class Body>
void Measure(benchmark::State& state, const Body& body, std::size_t written = 0) {
  Input& input = InputOf(static_cast<std::uint64_t>(state.range(0)));
  ThreadArena arena(static_cast<int>(state.range(1)));
  double nanoseconds = 0;
  arena.Execute([&] {
    const auto begin = Context::Clock::now();
    for (auto _ : state) body(input);
    nanoseconds = std::chrono::duration<double, std::nano>(Context::Clock::now() - begin).count() /
                  static_cast<double>(state.iterations());
  });
  state.counters["ns_per_vertex"] = nanoseconds / static_cast<double>(input.given.vertex_count());
  if (written != 0) {
    state.counters["ns_per_written"] = nanoseconds / static_cast<double>(written);
  }
}

void BM_Build(benchmark::State& state) {
  Measure(state, [](Input& input) {
    const auto mesh = HalfEdgeMesh::Build(input.context, input.given);
    benchmark::DoNotOptimize(mesh->twin().data());
  });
}

// One Chebyshev sweep: the time of 32 sweeps less that of none, by the solver's own loop.
void BM_Sweep(benchmark::State& state) {
  constexpr std::uint32_t kSweeps = 32;
  Input& input = InputOf(static_cast<std::uint64_t>(state.range(0)));
  ThreadArena arena(static_cast<int>(state.range(1)));
  const auto solve_time = [&](std::uint32_t sweeps) {
    const auto begin = Context::Clock::now();
    OrDie(Solve(input.context,
                {.mesh = input.mesh,
                 .stencil = input.stencil,
                 .points = input.given.positions,
                 .scale = input.box.diagonal()},
                {.tolerance = 0, .max_sweeps = sweeps}, absl::MakeSpan(input.control))
              .status());
    return std::chrono::duration<double>(Context::Clock::now() - begin).count();
  };
  double seconds = 0;
  arena.Execute([&] {
    for (auto _ : state) {
      const double sweeps = (solve_time(kSweeps) - solve_time(0)) / kSweeps;
      state.SetIterationTime(sweeps);
      seconds += sweeps;
    }
  });
  state.counters["ns_per_vertex"] =
      1e9 * seconds / static_cast<double>(state.iterations() * state.range(0));
}

void BM_SolveTo1e6(benchmark::State& state) {
  Measure(state, [](Input& input) {
    OrDie(Solve(input.context,
                {.mesh = input.mesh,
                 .stencil = input.stencil,
                 .points = input.given.positions,
                 .scale = input.box.diagonal()},
                {.tolerance = 1e-6}, absl::MakeSpan(input.control))
              .status());
  });
}

void BM_FirstRefinement(benchmark::State& state) {
  Measure(state, [](Input& input) {
    OrDie(FirstRefinement(input.context, input.mesh, input.control, absl::MakeSpan(input.first)));
  });
}

void BM_Perturb(benchmark::State& state) {
  Measure(state, [](Input& input) {
    OrDie(PerturbToInterpolate(input.context, {input.mesh, input.given.positions},
                               absl::MakeSpan(input.first)));
  });
}

void BM_QuadSplit(benchmark::State& state) {
  Measure(state, [](Input& input) {
    const auto split = SplitIntoQuads(input.context, input.mesh);
    benchmark::DoNotOptimize(split->twin().data());
  });
}

// The perturbed first refined mesh from the control mesh: points and connectivity.
void BM_PerturbedFirstMesh(benchmark::State& state) {
  Measure(state, [](Input& input) {
    OrDie(FirstRefinement(input.context, input.mesh, input.control, absl::MakeSpan(input.first)));
    OrDie(PerturbToInterpolate(input.context, {input.mesh, input.given.positions},
                               absl::MakeSpan(input.first)));
    const auto split = SplitIntoQuads(input.context, input.mesh);
    benchmark::DoNotOptimize(split->twin().data());
  });
}

// M^1 to M^2 into memory that is there already.
void BM_Refine(benchmark::State& state) {
  Measure(
      state,
      [](Input& input) {
        OrDie(RefineDooSabin(input.context, {.mesh = input.mesh, .fans = input.fans, .k = 1},
                             input.first, absl::MakeSpan(input.second)));
      },
      InputOf(static_cast<std::uint64_t>(state.range(0))).second.size());
}

// Points and normals of T^2 from M^2.
void BM_Limit(benchmark::State& state) {
  const Input& made = InputOf(static_cast<std::uint64_t>(state.range(0)));
  const std::size_t vertices =
      made.split.vertex_count() + made.split.edge_count() + made.split.face_count();
  Buffer<Vec3> points(vertices, Vec3{0, 0, 0});
  Buffer<Vec3> normals(vertices, Vec3{0, 0, 0});
  Measure(
      state,
      [&](Input& input) {
        OrDie(DooSabinLimit(
            input.context, {.mesh = input.split, .fans = input.fans, .k = 2}, input.second,
            {.points = absl::MakeSpan(points), .normals = absl::MakeSpan(normals)}));
      },
      vertices);
}

// Every tenth edge has a value of its own, as in a model that somebody works on.
Constraints SomeFeatures(const Input& of) {
  Constraints constraints;
  FeatureValues& values = constraints.features.emplace();
  const PolygonWalk walk(of.mesh);
  for (std::size_t e = 0; e < of.mesh.edge_count(); e += 10) {
    const Index h = of.mesh.edge_half_edge()[e];
    values.edges.push_back({.from = of.mesh.vertex()[h],
                            .to = of.mesh.vertex()[walk.Next(h)],
                            .value = static_cast<double>(e % 97) / 96});
  }
  return constraints;
}

// Feature values that have changed, on connectivity that is kept.
void BM_FeatureValues(benchmark::State& state) {
  Input& of = InputOf(static_cast<std::uint64_t>(state.range(0)));
  Constraints constraints = SomeFeatures(of);
  FeatureSurface surface = OrDie(FeatureSurface::Create(of.context, of.mesh));
  Measure(state, [&](Input& input) {
    constraints.features->default_edge = constraints.features->default_edge == 0.5 ? 0.4 : 0.5;
    OrDie(
        surface.Make(input.context, {.points = input.given.positions, .constraints = constraints}));
  });
}

// The same without anything kept.
void BM_FeatureValuesAfresh(benchmark::State& state) {
  Input& of = InputOf(static_cast<std::uint64_t>(state.range(0)));
  const Constraints constraints = SomeFeatures(of);
  Measure(state, [&](Input& input) {
    FeatureSurface surface = OrDie(FeatureSurface::Create(
        input.context, OrDie(HalfEdgeMesh::Build(input.context, input.given))));
    OrDie(
        surface.Make(input.context, {.points = input.given.positions, .constraints = constraints}));
    benchmark::DoNotOptimize(surface.surface().corners.data());
  });
}

// The whole job to level 2, with all its allocations.
void BM_Interpolate(benchmark::State& state) {
  Measure(state, [](Input& input) {
    const auto result = Interpolate(input.context, input.given, {.solve = {.tolerance = 1e-6}});
    benchmark::DoNotOptimize(result->surface.positions.data());
  });
}

// Sizes outermost, so that each mesh is made once.
void Register() {
  const std::vector<std::pair<const char*, void (*)(benchmark::State&)>> stages = {
      {"Build", BM_Build},
      {"SolveTo1e6", BM_SolveTo1e6},
      {"FirstRefinement", BM_FirstRefinement},
      {"Perturb", BM_Perturb},
      {"QuadSplit", BM_QuadSplit},
      {"PerturbedFirstMesh", BM_PerturbedFirstMesh},
      {"Refine", BM_Refine},
      {"Limit", BM_Limit},
      {"FeatureValues", BM_FeatureValues},
      {"FeatureValuesAfresh", BM_FeatureValuesAfresh},
      {"Interpolate", BM_Interpolate}};
  for (const std::int64_t vertices : {11540, 100000, 1000000}) {
    for (const std::int64_t threads : {1, 2}) {
      benchmark::RegisterBenchmark("Sweep", BM_Sweep)
          ->Args({vertices, threads})
          ->ArgNames({"vertices", "threads"})
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
      for (const auto& [name, function] : stages) {
        benchmark::RegisterBenchmark(name, function)
            ->Args({vertices, threads})
            ->ArgNames({"vertices", "threads"})
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace
}  // namespace limn

int main(int argc, char** argv) {
  limn::KeepHeap();
  limn::Register();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
