// SPDX-License-Identifier: MIT
// Time of exact evaluation, in nanoseconds per parameter. Run:
//   build/release/bin/evaluate_benchmark
//   build/release/bin/evaluate_benchmark --benchmark_filter=Near --benchmark_repetitions=5
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "engine/base/parallel.h"
#include "engine/interpolate.h"
#include "engine/limit/evaluate.h"
#include "engine/mesh/generate.h"

namespace limn {
namespace {

constexpr std::size_t kParameters = 100'000;

template <class T>
T OrDie(absl::StatusOr<T> value) {
  if (!value.ok()) std::abort();
  return *std::move(value);
}
void OrDie(const absl::Status& status) {
  if (!status.ok()) std::abort();
}

DooSabinSurface MakeSurface(MeshKind kind, std::uint64_t vertices) {
  const PolygonMesh given = OrDie(GenerateMesh({.kind = kind, .vertices = vertices}));
  return *OrDie(Interpolate(Context(), given, {.surface = false, .keep_patches = true})).patches;
}

// In patches at random; u and v in [0, 2^-halvings].
std::vector<SurfaceParameter> MakeParameters(const HalfEdgeMesh& mesh, int halvings) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(0, std::ldexp(1, -halvings));
  std::vector<SurfaceParameter> parameters(kParameters);
  for (SurfaceParameter& p : parameters) {
    const auto h = static_cast<Index>(random() % mesh.half_edge_count());
    p = {.face = mesh.face()[h], .corner = h - mesh.face_begin()[mesh.face()[h]]};
    p.u = coordinate(random);
    p.v = coordinate(random);
  }
  return parameters;
}

// Points, derivatives and normals at all parameters.
void Measure(benchmark::State& state, const DooSabinSurface& surface, int halvings) {
  const std::vector<SurfaceParameter> parameters = MakeParameters(surface.mesh, halvings);
  const Context context;
  const SurfaceEvaluator evaluator = OrDie(SurfaceEvaluator::Create(context, surface));
  std::vector<Vec3> out(4 * kParameters);
  const absl::Span<Vec3> all = absl::MakeSpan(out);
  ThreadArena arena(static_cast<int>(state.range(0)));
  double nanoseconds = 0;
  arena.Execute([&] {
    const auto begin = Context::Clock::now();
    for (auto _ : state) {
      OrDie(evaluator.Evaluate(context, parameters,
                               {.points = all.subspan(0, kParameters),
                                .du = all.subspan(kParameters, kParameters),
                                .dv = all.subspan(2 * kParameters, kParameters),
                                .normals = all.subspan(3 * kParameters, kParameters)}));
    }
    nanoseconds = std::chrono::duration<double, std::nano>(Context::Clock::now() - begin).count() /
                  static_cast<double>(state.iterations());
  });
  state.counters["ns_per_parameter"] = nanoseconds / static_cast<double>(kParameters);
}

void Register() {
  struct Case {
    const char* name;
    MeshKind kind;
    std::uint64_t vertices;
    int halvings;
  };
  for (const Case& c :
       {Case{"Irregular", MeshKind::kIrregularSphere, 11'540, 0},
        Case{"IrregularMillion", MeshKind::kIrregularSphere, 1'000'000, 0},
        Case{"MostlyRegular", MeshKind::kCube, 11'540, 0}, Case{"Hub", MeshKind::kHub, 11'540, 0},
        Case{"NearVertices", MeshKind::kIrregularSphere, 11'540, 20},
        Case{"NearestVertices", MeshKind::kIrregularSphere, 11'540, 1060}}) {
    benchmark::RegisterBenchmark(
        c.name,
        [c](benchmark::State& state) {
          static std::uint64_t kept = 0;
          static MeshKind kind;
          static std::unique_ptr<DooSabinSurface> surface;
          if (kept != c.vertices || kind != c.kind) {
            kept = c.vertices;
            kind = c.kind;
            surface = std::make_unique<DooSabinSurface>(MakeSurface(c.kind, c.vertices));
          }
          Measure(state, *surface, c.halvings);
        })
        ->ArgName("threads")
        ->Arg(1)
        ->Arg(2)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
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
