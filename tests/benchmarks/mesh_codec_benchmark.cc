// SPDX-License-Identifier: MIT
// Speed and size of the mesh encodings, per vertex of a torus of quads.
//
// Run:  build/release/bin/mesh_codec_benchmark
//       build/release/bin/mesh_codec_benchmark --benchmark_filter=Decode/PACKED
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "proto/wire/mesh_codec.h"

namespace limn::wire {
namespace {

// n * 2n quads, their vertices a little off the torus so that coordinates are as in real models.
PolygonMesh Torus(Index n) {
  const Index m = 2 * n;
  PolygonMesh mesh;
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double u = 2 * std::numbers::pi * i / m;
      const double v = 2 * std::numbers::pi * j / n;
      const double r = 3 + std::cos(v) + 0.001 * std::sin(12.9898 * i + 78.233 * j);
      mesh.positions.push_back({r * std::cos(u), r * std::sin(u), std::sin(v)});
      const Index next_i = (i + 1) % m;
      const Index next_j = (j + 1) % n;
      const Index face[] = {i * n + j, next_i * n + j, next_i * n + next_j, i * n + next_j};
      mesh.AddFace(face);
    }
  }
  return mesh;
}

void Report(benchmark::State& state, std::size_t vertices, std::size_t bytes) {
  state.counters["per_vertex"] = benchmark::Counter(
      static_cast<double>(vertices),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["bytes/vertex"] = static_cast<double>(bytes) / static_cast<double>(vertices);
}

void Encode(benchmark::State& state, v1::MeshEncoding encoding) {
  const PolygonMesh mesh = Torus(static_cast<Index>(state.range(0)));
  std::size_t bytes = 0;
  for (auto _ : state) {
    auto encoded = EncodeMesh(Context(), mesh, {.encoding = encoding});
    if (!encoded.ok()) {
      state.SkipWithError(encoded.status().ToString().c_str());
      return;
    }
    bytes = encoded->bytes.size();
  }
  Report(state, mesh.vertex_count(), bytes);
}

void Decode(benchmark::State& state, v1::MeshEncoding encoding) {
  const PolygonMesh mesh = Torus(static_cast<Index>(state.range(0)));
  const auto encoded = EncodeMesh(Context(), mesh, {.encoding = encoding});
  if (!encoded.ok()) {
    state.SkipWithError(encoded.status().ToString().c_str());
    return;
  }
  for (auto _ : state) {
    auto decoded = DecodeMesh(Context(), encoded->header, encoded->bytes);
    if (!decoded.ok()) {
      state.SkipWithError(decoded.status().ToString().c_str());
      return;
    }
    benchmark::DoNotOptimize(decoded->positions.data());
  }
  Report(state, mesh.vertex_count(), encoded->bytes.size());
}

// 11,552, 100,352 and 999,698 vertices.
void Sizes(benchmark::internal::Benchmark* benchmark) {
  benchmark->Arg(76)->Arg(224)->Arg(707)->UseRealTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(Encode, PACKED, v1::MESH_ENCODING_PACKED)->Apply(Sizes);
BENCHMARK_CAPTURE(Decode, PACKED, v1::MESH_ENCODING_PACKED)->Apply(Sizes);
BENCHMARK_CAPTURE(Encode, DRACO, v1::MESH_ENCODING_DRACO)->Apply(Sizes);
BENCHMARK_CAPTURE(Decode, DRACO, v1::MESH_ENCODING_DRACO)->Apply(Sizes);
BENCHMARK_CAPTURE(Encode, DRACO_QUANTIZED, v1::MESH_ENCODING_DRACO_QUANTIZED)->Apply(Sizes);
BENCHMARK_CAPTURE(Decode, DRACO_QUANTIZED, v1::MESH_ENCODING_DRACO_QUANTIZED)->Apply(Sizes);

}  // namespace
}  // namespace limn::wire

BENCHMARK_MAIN();
