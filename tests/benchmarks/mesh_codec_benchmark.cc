// SPDX-License-Identifier: MIT
// Speed and size of the encodings, of meshes per vertex and of results, as streams of tiles, per
// vertex of the tessellation.
//
// Run:  build/release/bin/mesh_codec_benchmark
//       build/release/bin/mesh_codec_benchmark --benchmark_filter=Decode/PACKED
// Arguments: vertices (irregular sphere, polygons of 3 to 8 sides; tiles: of its tessellation at
// level 1, with normals) and threads; one where the encoding has no more.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/heap.h"
#include "engine/base/parallel.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/tile_codec.h"

namespace limn::wire {
namespace {

template <class T>
T OrDie(absl::StatusOr<T> value) {
  if (!value.ok()) std::abort();
  return *std::move(value);
}

struct Input {
  explicit Input(std::uint64_t vertices)
      : mesh(OrDie(GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices}))),
        surface(OrDie(Interpolate(Context(), mesh, {.level = 1})).surface) {}

  PolygonMesh mesh;
  Tessellation surface;
};

// The latest size is kept: a million vertices take a second to make.
const Input& InputOf(std::int64_t vertices) {
  static std::int64_t kept = 0;
  static std::unique_ptr<Input> input;
  if (kept != vertices) {
    input.reset();
    input = std::make_unique<Input>(static_cast<std::uint64_t>(vertices));
    kept = vertices;
  }
  return *input;
}

// Runs body() as often as it takes on the threads of the second argument.
template <class Body>
void Measure(benchmark::State& state, std::size_t vertices, const Body& body) {
  ThreadArena arena(static_cast<int>(state.range(1)));
  std::size_t bytes = 0;
  arena.Execute([&] {
    for (auto _ : state) bytes = body();
  });
  state.counters["per_vertex"] = benchmark::Counter(
      static_cast<double>(vertices),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["bytes/vertex"] = static_cast<double>(bytes) / static_cast<double>(vertices);
}

void Encode(benchmark::State& state, v1::MeshEncoding encoding) {
  const PolygonMesh& mesh = InputOf(state.range(0)).mesh;
  Measure(state, mesh.vertex_count(),
          [&] { return OrDie(EncodeMesh(Context(), mesh, {.encoding = encoding})).bytes.size(); });
}

void Decode(benchmark::State& state, v1::MeshEncoding encoding) {
  const PolygonMesh& mesh = InputOf(state.range(0)).mesh;
  const auto encoded = OrDie(EncodeMesh(Context(), mesh, {.encoding = encoding}));
  Measure(state, mesh.vertex_count(), [&] {
    auto decoded = OrDie(DecodeMesh(Context(), encoded.header, encoded.bytes));
    benchmark::DoNotOptimize(decoded.positions.data());
    return encoded.bytes.size();
  });
}

TileOptions OptionsFor(const Tessellation& surface, v1::MeshEncoding encoding) {
  TileOptions options = {.encoding = encoding};
  if (encoding == v1::MESH_ENCODING_DRACO_QUANTIZED) {
    options.grid = OrDie(FitGrid(Context(), surface.positions, surface.normals));
  }
  return options;
}

std::vector<v1::SurfaceTile> Tiles(const Tessellation& surface, const TileOptions& options) {
  std::vector<v1::SurfaceTile> tiles;
  for (const TileRange& range : OrDie(PlanTiles(surface, options))) {
    const auto index = static_cast<std::uint32_t>(tiles.size());
    tiles.push_back(OrDie(EncodeTile(Context(), surface, range, index, options)));
  }
  return tiles;
}

std::size_t BytesOf(const std::vector<v1::SurfaceTile>& tiles) {
  std::size_t bytes = 0;
  for (const v1::SurfaceTile& tile : tiles) bytes += tile.ByteSizeLong();
  return bytes;
}

void EncodeTiles(benchmark::State& state, v1::MeshEncoding encoding) {
  const Tessellation& surface = InputOf(state.range(0)).surface;
  Measure(state, surface.vertex_count(),
          [&] { return BytesOf(Tiles(surface, OptionsFor(surface, encoding))); });
}

void DecodeTiles(benchmark::State& state, v1::MeshEncoding encoding) {
  const Tessellation& surface = InputOf(state.range(0)).surface;
  const std::vector<v1::SurfaceTile> tiles = Tiles(surface, OptionsFor(surface, encoding));
  const std::size_t bytes = BytesOf(tiles);
  Measure(state, surface.vertex_count(), [&] {
    SurfaceAssembler assembler(surface.vertex_count(), surface.face_count());
    for (const v1::SurfaceTile& tile : tiles) {
      if (!assembler.Add(tile).ok()) std::abort();
    }
    benchmark::DoNotOptimize(OrDie(assembler.Finish()).positions.data());
    return bytes;
  });
}

// Sizes outermost, so that each mesh is made once.
void Register() {
  struct Encoding {
    const char* name;
    v1::MeshEncoding encoding;
    std::vector<std::int64_t> threads;
  };
  // Draco's own loops are serial; the grid of the quantised one is found in parallel.
  const std::vector<Encoding> encodings = {
      {"PACKED", v1::MESH_ENCODING_PACKED, {1, 2}},
      {"DRACO", v1::MESH_ENCODING_DRACO, {1}},
      {"DRACO_QUANTIZED", v1::MESH_ENCODING_DRACO_QUANTIZED, {1, 2}}};
  using Function = void (*)(benchmark::State&, v1::MeshEncoding);
  const std::vector<std::pair<const char*, Function>> functions = {{"Encode/", Encode},
                                                                   {"Decode/", Decode},
                                                                   {"EncodeTiles/", EncodeTiles},
                                                                   {"DecodeTiles/", DecodeTiles}};
  for (const std::int64_t vertices : {11540, 100000, 1000000}) {
    for (const auto& [name, function] : functions) {
      for (const Encoding& encoding : encodings) {
        for (const std::int64_t threads : encoding.threads) {
          benchmark::RegisterBenchmark((std::string(name) + encoding.name).c_str(), function,
                                       encoding.encoding)
              ->Args({vertices, threads})
              ->ArgNames({"vertices", "threads"})
              ->UseRealTime()
              ->Unit(benchmark::kMillisecond);
        }
      }
    }
  }
}

}  // namespace
}  // namespace limn::wire

int main(int argc, char** argv) {
  limn::KeepHeap();
  limn::wire::Register();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
