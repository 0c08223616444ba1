// SPDX-License-Identifier: MIT
// Time of Catmull-Clark and Loop refinement and limits, in nanoseconds per vertex of what they
// write. Run:
//   build/release/bin/refine_benchmark
//   build/release/bin/refine_benchmark --benchmark_filter='CatmullClark/Step.*/100000/'
// Arguments: vertices of T^0 (irregular sphere: polygons of 3 to 8 sides; for Loop cut into
// triangles) and threads. Step: connectivity and points of T^(k+1) from those of T^k, with all
// allocations; k is 0 or, in StepOfT1, 1. Split, Refine: the two by themselves, Refine into memory
// that is there. Limit: points and normals of T^1.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/parallel.h"
#include "engine/limit/vertex_limit.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "engine/refine/catmull_clark_refine.h"
#include "engine/refine/loop_refine.h"
#include "tests/oracle/test_meshes.h"

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

enum class Rule { kCatmullClark, kLoop };

HalfEdgeMesh Split(Rule rule, const HalfEdgeMesh& mesh) {
  const Context context;
  return OrDie(rule == Rule::kLoop ? SplitIntoTriangles(context, mesh)
                                   : SplitIntoQuads(context, mesh));
}

// A level, its points and room for the next one's.
struct Level {
  Level(Rule scheme, HalfEdgeMesh connectivity, Buffer<Vec3> positions)
      : rule(scheme), mesh(std::move(connectivity)), points(std::move(positions)) {
    const std::size_t faces = rule == Rule::kLoop ? 0 : mesh.face_count();
    refined.resize(mesh.vertex_count() + mesh.edge_count() + faces, Vec3{0, 0, 0});
  }
  void Refine(absl::Span<Vec3> out) const {
    const Context context;
    const SurfaceLevel level = {mesh, sharpness};
    OrDie(rule == Rule::kLoop ? RefineLoop(context, level, points, out)
                              : RefineCatmullClark(context, level, points, out));
  }
  void Limit(absl::Span<Vec3> limits, absl::Span<Vec3> normals) const {
    const Context context;
    const SurfaceLevel level = {mesh, sharpness};
    const VertexLimits out = {limits, {}, normals};
    OrDie(rule == Rule::kLoop ? LoopLimits(context, level, points, out)
                              : CatmullClarkLimits(context, level, points, out));
  }

  Rule rule;
  HalfEdgeMesh mesh;
  Buffer<Vec3> points;
  Buffer<Vec3> refined;
  Sharpness sharpness;
};

Level MakeLevel(Rule rule, std::uint64_t vertices) {
  PolygonMesh given =
      OrDie(GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices}));
  if (rule == Rule::kLoop) given = oracle::Triangulated(given);
  return {rule, OrDie(HalfEdgeMesh::Build(Context(), given)), given.positions};
}

// The latest one is kept: a million vertices take a second to make.
Level& LevelOf(Rule rule, std::uint64_t vertices, int k) {
  static std::string kept;
  static std::unique_ptr<Level> level;
  const std::string name = std::to_string(static_cast<int>(rule)) + " " + std::to_string(vertices) +
                           " " + std::to_string(k);
  if (kept != name) {
    level.reset();
    level = std::make_unique<Level>(MakeLevel(rule, vertices));
    for (int i = 0; i < k; ++i) {
      level->Refine(absl::MakeSpan(level->refined));
      level = std::make_unique<Level>(rule, Split(rule, level->mesh), level->refined);
    }
    kept = name;
  }
  return *level;
}

// Runs body() in an arena of the wanted threads. written: vertices.
template <class Body>
void Measure(benchmark::State& state, std::size_t written, const Body& body) {
  ThreadArena arena(static_cast<int>(state.range(1)));
  double nanoseconds = 0;
  arena.Execute([&] {
    const auto begin = Context::Clock::now();
    for (auto _ : state) body();
    nanoseconds = std::chrono::duration<double, std::nano>(Context::Clock::now() - begin).count() /
                  static_cast<double>(state.iterations());
  });
  state.counters["ns_per_written"] = nanoseconds / static_cast<double>(written);
}

void BM_Step(benchmark::State& state, Rule rule, int k) {
  const Level& level = LevelOf(rule, static_cast<std::uint64_t>(state.range(0)), k);
  Measure(state, level.refined.size(), [&] {
    const HalfEdgeMesh split = Split(rule, level.mesh);
    Buffer<Vec3> refined(split.vertex_count());
    level.Refine(absl::MakeSpan(refined));
    benchmark::DoNotOptimize(split.twin().data());
    benchmark::DoNotOptimize(refined.data());
  });
}

void BM_Split(benchmark::State& state, Rule rule) {
  const Level& level = LevelOf(rule, static_cast<std::uint64_t>(state.range(0)), 0);
  Measure(state, level.refined.size(), [&] {
    const HalfEdgeMesh split = Split(rule, level.mesh);
    benchmark::DoNotOptimize(split.twin().data());
  });
}

void BM_Refine(benchmark::State& state, Rule rule) {
  Level& level = LevelOf(rule, static_cast<std::uint64_t>(state.range(0)), 0);
  Measure(state, level.refined.size(), [&] { level.Refine(absl::MakeSpan(level.refined)); });
}

void BM_Limit(benchmark::State& state, Rule rule) {
  const Level& level = LevelOf(rule, static_cast<std::uint64_t>(state.range(0)), 1);
  Buffer<Vec3> points(level.points.size(), Vec3{0, 0, 0});
  Buffer<Vec3> normals(level.points.size(), Vec3{0, 0, 0});
  Measure(state, points.size(),
          [&] { level.Limit(absl::MakeSpan(points), absl::MakeSpan(normals)); });
}

// Sizes outermost, so that each mesh is made once.
void Register() {
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    const std::string scheme = rule == Rule::kLoop ? "Loop/" : "CatmullClark/";
    for (const std::int64_t vertices : {11540, 100000, 1000000}) {
      const auto add = [&](const std::string& name, auto&& function) {
        for (const std::int64_t threads : {1, 2}) {
          benchmark::RegisterBenchmark((scheme + name).c_str(), function)
              ->Args({vertices, threads})
              ->ArgNames({"vertices", "threads"})
              ->UseRealTime()
              ->Unit(benchmark::kMillisecond);
        }
      };
      add("Step", [rule](benchmark::State& state) { BM_Step(state, rule, 0); });
      add("Split", [rule](benchmark::State& state) { BM_Split(state, rule); });
      add("Refine", [rule](benchmark::State& state) { BM_Refine(state, rule); });
      add("StepOfT1", [rule](benchmark::State& state) { BM_Step(state, rule, 1); });
      add("Limit", [rule](benchmark::State& state) { BM_Limit(state, rule); });
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
