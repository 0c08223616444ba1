// SPDX-License-Identifier: MIT
// Time of exact evaluation, in nanoseconds per parameter. Run:
//   build/release/bin/evaluate_benchmark
//   build/release/bin/evaluate_benchmark --benchmark_filter=CatmullClark --benchmark_repetitions=5
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/base/parallel.h"
#include "engine/interpolate.h"
#include "engine/limit/evaluate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/primal_surface.h"

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

enum class Family { kDooSabin, kCatmullClark, kLoop };

// A surface to evaluate: the one that passes through a mesh's vertices, or (Catmull-Clark, Loop)
// that of the mesh itself.
struct Scene {
  PolygonMesh given;
  std::optional<DooSabinSurface> doo_sabin;
  std::optional<PrimalSurface> primal;

  SurfaceEvaluator Evaluator() const {
    return doo_sabin.has_value() ? OrDie(SurfaceEvaluator::Create(Context(), *doo_sabin))
                                 : OrDie(SurfaceEvaluator::Create(Context(), *primal));
  }
};

std::unique_ptr<Scene> MakeScene(Family family, MeshKind kind, std::uint64_t vertices) {
  auto scene = std::make_unique<Scene>();
  scene->given = OrDie(GenerateMesh({.kind = kind, .vertices = vertices}));
  if (family == Family::kDooSabin) {
    scene->doo_sabin = std::get<DooSabinSurface>(
        *OrDie(Interpolate(Context(), scene->given, {.surface = false, .keep_patches = true}))
             .patches);
    return scene;
  }
  if (family == Family::kLoop) scene->given = oracle::Triangulated(scene->given);
  scene->primal = oracle::PrimalSurfaceOf(
      scene->given, family == Family::kLoop ? oracle::Rule::kLoop : oracle::Rule::kCatmullClark,
      {});
  return scene;
}

// In patches at random; u and v in [0, 2^-halvings], of triangles half of that.
std::vector<SurfaceParameter> MakeParameters(const PolygonMesh& mesh, bool triangles,
                                             int halvings) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(0, std::ldexp(1, -halvings));
  std::vector<SurfaceParameter> parameters(kParameters);
  for (SurfaceParameter& p : parameters) {
    p.face = static_cast<Index>(random() % mesh.face_count());
    p.corner = static_cast<Index>(random() % mesh.arity(p.face));
    p.u = coordinate(random);
    p.v = coordinate(random);
    if (triangles && p.u + p.v > std::ldexp(1, -halvings)) {
      p.u /= 2;
      p.v /= 2;
    }
  }
  return parameters;
}

// Points, derivatives and normals at all parameters.
void Measure(benchmark::State& state, const Scene& scene, bool triangles, int halvings) {
  const std::vector<SurfaceParameter> parameters = MakeParameters(scene.given, triangles, halvings);
  const Context context;
  const SurfaceEvaluator evaluator = scene.Evaluator();
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

struct Case {
  const char* name;
  MeshKind kind;
  std::uint64_t vertices;
  int halvings;
};

void Register(Family family, const std::string& prefix, const std::vector<Case>& cases) {
  for (const Case& c : cases) {
    benchmark::RegisterBenchmark((prefix + c.name).c_str(),
                                 [c, family](benchmark::State& state) {
                                   // The last one, so that not all are kept at once.
                                   static std::tuple<Family, MeshKind, std::uint64_t> kept;
                                   static std::unique_ptr<Scene> scene;
                                   const std::tuple wanted(family, c.kind, c.vertices);
                                   if (scene == nullptr || kept != wanted) {
                                     kept = wanted;
                                     scene = MakeScene(family, c.kind, c.vertices);
                                   }
                                   Measure(state, *scene, family == Family::kLoop, c.halvings);
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
  using limn::Case;
  using limn::Family;
  using limn::MeshKind;
  std::vector<Case> cases = {{"Irregular", MeshKind::kIrregularSphere, 11'540, 0},
                             {"MostlyRegular", MeshKind::kCube, 11'540, 0},
                             {"NearVertices", MeshKind::kIrregularSphere, 11'540, 20},
                             {"NearestVertices", MeshKind::kIrregularSphere, 11'540, 1060}};
  limn::Register(Family::kCatmullClark, "CatmullClark/", cases);
  limn::Register(Family::kLoop, "Loop/", cases);
  cases.push_back({"IrregularMillion", MeshKind::kIrregularSphere, 1'000'000, 0});
  cases.push_back({"Hub", MeshKind::kHub, 11'540, 0});
  limn::Register(Family::kDooSabin, "DooSabin/", cases);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
