// SPDX-License-Identifier: MIT
// Surfaces as tiles: what comes back is what was cut up, tile by tile and whole.
#include "proto/wire/tile_codec.h"

#include <algorithm>
#include <limits>
#include <map>
#include <random>

#include "proto/wire/draco_encoder.h"
#include "tests/wire/test_meshes.h"

namespace limn::wire {
namespace {

constexpr std::uint32_t kSeed = 31;
constexpr v1::MeshEncoding kAll[] = {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO,
                                     v1::MESH_ENCODING_DRACO_QUANTIZED};

// What float32 keeps. Through memory: at -O3, GCC 12 drops a vectorised conversion there and back.
double AsFloat(double x) {
  const volatile float narrow = static_cast<float>(x);
  return narrow;
}

Tessellation Surface(const PolygonMesh& mesh, std::uint32_t arity, bool normals = true) {
  Tessellation surface;
  surface.positions = mesh.positions;
  surface.arity = arity;
  if (arity == 0) surface.face_begin = mesh.face_begin;
  surface.face_vertices = mesh.corner_vertex;
  for (std::size_t v = 0; normals && v < mesh.vertex_count(); ++v) {
    const Vec3 n = NormalizedOrZero({std::sin(1.0 * v), std::cos(2.0 * v), 0.5});
    surface.normals.push_back({AsFloat(n.x), AsFloat(n.y), AsFloat(n.z)});
  }
  return surface;
}

std::vector<Tessellation> Surfaces() {
  return {Surface(Torus(60, 50), 4), Surface(Torus(60, 50), 4, false),
          Surface(IrregularTorus(40, 30, kSeed), 0), Surface(Tetrahedron(), 3, false),
          Surface(Prism(30), 0, false)};
}

std::vector<v1::SurfaceTile> EncodeTiles(const Tessellation& surface, const TileOptions& options) {
  const auto plan = PlanTiles(surface, options);
  EXPECT_TRUE(plan.ok()) << plan.status();
  std::vector<v1::SurfaceTile> tiles;
  for (std::uint32_t i = 0; plan.ok() && i < plan->size(); ++i) {
    const auto tile = EncodeTile(Context(), surface, (*plan)[i], i, options);
    EXPECT_TRUE(tile.ok()) << tile.status();
    if (tile.ok()) tiles.push_back(*tile);
  }
  return tiles;
}

absl::StatusOr<Tessellation> Assemble(const std::vector<v1::SurfaceTile>& tiles) {
  SurfaceAssembler assembler(1 << 20, 1 << 20);
  for (const v1::SurfaceTile& tile : tiles) LIMN_RETURN_IF_ERROR(assembler.Add(tile));
  return assembler.Finish();
}

PolygonMesh AsMesh(const Tessellation& surface) {
  PolygonMesh mesh;
  mesh.positions = surface.positions;
  mesh.corner_vertex = surface.face_vertices;
  mesh.face_begin = surface.face_begin;
  for (std::size_t f = 0; surface.arity != 0 && f <= surface.face_count(); ++f) {
    mesh.face_begin.push_back(static_cast<Index>(f * surface.arity));
  }
  return mesh;
}

TEST(PlanTilesTest, PackedRunsCoverVerticesAndFacesOnceWithinTheSize) {
  for (const Tessellation& surface : Surfaces()) {
    const TileOptions options = {.tile_bytes = kMinTileBytes};
    std::uint64_t vertex = 0, face = 0;
    const std::vector<TileRange> plan = *PlanTiles(surface, options);
    for (const TileRange& range : plan) {
      EXPECT_EQ(range.first_vertex, vertex);
      EXPECT_EQ(range.first_face, face);
      vertex += range.vertex_count;
      face += range.face_count;
      const auto tile = EncodeTile(Context(), surface, range, 0, options);
      ASSERT_TRUE(tile.ok());
      EXPECT_LE(tile->positions().size() + tile->normals().size() + tile->face_vertices().size() +
                    tile->arities().size(),
                kMinTileBytes);
    }
    EXPECT_EQ(vertex, surface.vertex_count());
    EXPECT_EQ(face, surface.face_count());
  }
}

TEST(PlanTilesTest, DracoRunsCoverFacesOnceWithinTheSize) {
  for (const Tessellation& surface : Surfaces()) {
    const TileOptions options = {.encoding = v1::MESH_ENCODING_DRACO, .tile_bytes = kMinTileBytes};
    std::uint64_t face = 0;
    const std::vector<TileRange> plan = *PlanTiles(surface, options);
    for (const TileRange& range : plan) {
      EXPECT_EQ(range.vertex_count, 0U);
      EXPECT_EQ(range.first_face, face);
      EXPECT_GE(range.face_count, 1U);
      face += range.face_count;
      const auto tile = EncodeTile(Context(), surface, range, 0, options);
      ASSERT_TRUE(tile.ok()) << tile.status();
      EXPECT_LE(tile->vertex_count() * 40 + tile->face_count() * 4, kMinTileBytes);
    }
    EXPECT_EQ(face, surface.face_count());
  }
}

TEST(PlanTilesTest, EmptySurfaceHasNoTiles) {
  for (const v1::MeshEncoding encoding : kAll) {
    EXPECT_TRUE(PlanTiles(Tessellation(), {.encoding = encoding})->empty());
  }
}

TEST(PlanTilesTest, RefusesOptionsOutOfRange) {
  const Tessellation surface = Surface(Torus(4, 4), 4);
  const auto error = [&](const TileOptions& options) {
    return PlanTiles(surface, options).status();
  };
  ExpectError(error({.encoding = static_cast<v1::MeshEncoding>(7)}), Reason::kInvalidOption,
              "encoding");
  for (const int bits : {7, 31}) {
    ExpectError(error({.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED, .quantization_bits = bits}),
                Reason::kInvalidOption, "quantization_bits");
  }
  for (const std::uint32_t bytes : {kMinTileBytes - 1, kMaxTileBytes + 1}) {
    ExpectError(error({.tile_bytes = bytes}), Reason::kInvalidOption, "tile_bytes");
  }
  ExpectError(error({.encoding = v1::MESH_ENCODING_DRACO, .omit_connectivity = true}),
              Reason::kInvalidOption, "omit_connectivity");
}

TEST(PlanTilesTest, RefusesAFaceThatIsLargerThanATile) {
  const Tessellation surface = Surface(Prism(2000), 0);
  for (const v1::MeshEncoding encoding : kAll) {
    ExpectError(PlanTiles(surface, {.encoding = encoding, .tile_bytes = kMinTileBytes}).status(),
                Reason::kLimitExceeded, "faces");
  }
  EXPECT_TRUE(PlanTiles(surface, {}).ok());
}

TEST(TileCodecTest, LosslessTilesKeepEveryBitInAnyOrderOfArrival) {
  std::mt19937 random(kSeed);
  for (const v1::MeshEncoding encoding : {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO}) {
    for (const Tessellation& surface : Surfaces()) {
      auto tiles = EncodeTiles(surface, {.encoding = encoding, .tile_bytes = 16 << 10});
      std::shuffle(tiles.begin(), tiles.end(), random);
      const auto back = Assemble(tiles);
      ASSERT_TRUE(back.ok()) << back.status();
      EXPECT_TRUE(SameBits(back->positions, surface.positions));
      EXPECT_TRUE(SameBits(back->normals, surface.normals));
      EXPECT_EQ(back->arity, surface.arity);
      EXPECT_EQ(back->face_begin, surface.face_begin);
      EXPECT_EQ(back->face_vertices, surface.face_vertices);
    }
  }
}

TEST(TileCodecTest, QuantizedTilesKeepTheFacesOfEachTile) {
  for (const Tessellation& surface : Surfaces()) {
    const TileOptions options = {.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED,
                                 .tile_bytes = 16 << 10};
    const auto back = Assemble(EncodeTiles(surface, options));
    ASSERT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->arity, surface.arity);
    EXPECT_EQ(FaceSet(AsMesh(*back)), FaceSet(AsMesh(surface)));
    EXPECT_LE(MaxDeviation(back->positions, surface.positions), 8.0 / 65535 / 2 * 1.01);
    EXPECT_LE(MaxDeviation(back->normals, surface.normals), 3e-4);
    const std::vector<TileRange> plan = *PlanTiles(surface, options);
    for (const TileRange& range : plan) {
      const auto tile = DecodeTile(*EncodeTile(Context(), surface, range, 0, options));
      ASSERT_TRUE(tile.ok());
      EXPECT_EQ(tile->first_face, range.first_face);
      EXPECT_EQ(tile->arities.size(), range.face_count);
    }
  }
}

TEST(TileCodecTest, AVertexHasTheSameValueInEveryQuantizedTile) {
  const Tessellation surface = Surface(IrregularTorus(40, 30, kSeed), 0);
  std::map<std::uint32_t, std::pair<Vec3, Vec3>> seen;
  std::size_t shared = 0;
  for (const v1::SurfaceTile& message :
       EncodeTiles(surface, {.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED,
                            .quantization_bits = 12,
                            .tile_bytes = kMinTileBytes})) {
    const DecodedTile tile = *DecodeTile(message);
    for (std::size_t i = 0; i < tile.positions.size(); ++i) {
      const auto [at, fresh] =
          seen.emplace(tile.vertex_ids[i], std::pair(tile.positions[i], tile.normals[i]));
      EXPECT_EQ(at->second.first, tile.positions[i]);
      EXPECT_EQ(at->second.second, tile.normals[i]);
      shared += !fresh;
    }
  }
  EXPECT_GT(shared, 500U);
}

TEST(TileCodecTest, AGridFoundOnceGivesTheSameTiles) {
  const Tessellation surface = Surface(Torus(30, 20), 4);
  TileOptions options = {.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED, .tile_bytes = 16 << 10};
  const auto without = EncodeTiles(surface, options);
  options.grid = *FitGrid(Context(), surface.positions, surface.normals);
  const auto with = EncodeTiles(surface, options);
  ASSERT_EQ(with.size(), without.size());
  for (std::size_t i = 0; i < with.size(); ++i) {
    EXPECT_EQ(with[i].SerializeAsString(), without[i].SerializeAsString());
  }
}

TEST(TileCodecTest, NormalsOfZeroLengthSurvive) {
  Tessellation surface = Surface(Torus(20, 20), 4);
  surface.normals[17] = {0, 0, 0};
  for (const v1::MeshEncoding encoding : kAll) {
    const auto back = Assemble(EncodeTiles(surface, {.encoding = encoding}));
    ASSERT_TRUE(back.ok());
    EXPECT_TRUE(SameBits(back->normals, surface.normals));
  }
}

// One uint32 per id would cost Draco's encoder tables as long as the largest number.
TEST(TileCodecTest, DracoTilesOfLargeNumbersAreSmall) {
  Tessellation surface = Surface(Cube(), 4, false);
  surface.positions.resize(3'000'000, Vec3{0, 0, 0});
  for (Index& v : surface.face_vertices) v = v == 7 ? 2'999'999 : v * 400'000;
  for (const v1::MeshEncoding encoding :
       {v1::MESH_ENCODING_DRACO, v1::MESH_ENCODING_DRACO_QUANTIZED}) {
    const auto tiles = EncodeTiles(surface, {.encoding = encoding, .grid = QuantizationGrid()});
    ASSERT_EQ(tiles.size(), 1U);
    EXPECT_LT(tiles[0].draco().size(), 600U);
    const DecodedTile tile = *DecodeTile(tiles[0]);
    EXPECT_THAT(tile.vertex_ids, testing::ElementsAre(0, 400'000, 800'000, 1'200'000, 1'600'000,
                                                      2'000'000, 2'400'000, 2'999'999));
  }
}

TEST(TileCodecTest, OmittedConnectivityLeavesASurfaceWithoutFaces) {
  const Tessellation surface = Surface(Torus(60, 50), 4);
  const auto tiles = EncodeTiles(surface, {.tile_bytes = kMinTileBytes, .omit_connectivity = true});
  EXPECT_GT(tiles.size(), 10U);
  const auto back = Assemble(tiles);
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_TRUE(SameBits(back->positions, surface.positions));
  EXPECT_TRUE(SameBits(back->normals, surface.normals));
  EXPECT_EQ(back->face_count(), 0U);
  EXPECT_TRUE(back->face_vertices.empty());
}

TEST(TileCodecTest, TilesTellTheirPlace) {
  const Tessellation surface = Surface(Torus(60, 50), 4);
  const TileOptions options = {.tile_bytes = 16 << 10};
  const auto plan = *PlanTiles(surface, options);
  const v1::SurfaceTile tile = *EncodeTile(Context(), surface, plan[3], 3, options);
  EXPECT_EQ(tile.index(), 3U);
  EXPECT_EQ(tile.encoding(), v1::MESH_ENCODING_PACKED);
  EXPECT_EQ(tile.first_vertex(), plan[3].first_vertex);
  EXPECT_EQ(tile.vertex_count(), plan[3].vertex_count);
  EXPECT_EQ(tile.first_face(), plan[3].first_face);
  EXPECT_EQ(tile.face_count(), plan[3].face_count);
  EXPECT_EQ(tile.arity(), 4U);
  EXPECT_EQ(tile.positions().size(), 24 * plan[3].vertex_count);
  EXPECT_EQ(tile.normals().size(), 12 * plan[3].vertex_count);
  EXPECT_EQ(tile.face_vertices().size(), 16 * plan[3].face_count);
  EXPECT_TRUE(tile.arities().empty());
}

TEST(EncodeTileTest, RefusesRangesBeyondTheSurfaceAndStops) {
  const Tessellation surface = Surface(Torus(4, 4), 4);
  constexpr std::uint64_t kHuge = std::numeric_limits<std::uint64_t>::max();
  for (const TileRange& range :
       {TileRange{.first_vertex = 10, .vertex_count = 7}, TileRange{.first_face = 17},
        TileRange{.first_face = 1, .face_count = 16},
        TileRange{.first_face = kHuge, .face_count = 2},
        TileRange{.first_vertex = 1, .vertex_count = kHuge}}) {
    ExpectError(EncodeTile(Context(), surface, range, 0, {}).status(), Reason::kInvalidOption,
                "range");
  }
  Context cancelled;
  cancelled.Cancel();
  for (const v1::MeshEncoding encoding : kAll) {
    ExpectError(
        EncodeTile(cancelled, surface, {.face_count = 4}, 0, {.encoding = encoding}).status(),
        Reason::kCancelled);
  }
}

class BrokenTileTest : public testing::Test {
 protected:
  const Tessellation surface_ = Surface(IrregularTorus(9, 9, kSeed), 0);
  const std::vector<v1::SurfaceTile> packed_ = EncodeTiles(surface_, {.tile_bytes = kMinTileBytes});
  const std::vector<v1::SurfaceTile> draco_ =
      EncodeTiles(surface_, {.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED, .tile_bytes = 8 << 10});

  template <class Break>
  void ExpectRefused(v1::SurfaceTile tile, const Break& break_tile) {
    ASSERT_TRUE(DecodeTile(tile).ok());
    break_tile(&tile);
    ExpectError(DecodeTile(tile).status(), Reason::kMalformedEncoding);
    ExpectError(SurfaceAssembler(1000, 1000).Add(tile), Reason::kMalformedEncoding);
  }
};

TEST_F(BrokenTileTest, ArraysMustBeAsLongAsTheirCountsSay) {
  const v1::SurfaceTile& tile = packed_[0];
  ExpectRefused(tile, [](auto* t) { t->mutable_positions()->pop_back(); });
  ExpectRefused(tile, [](auto* t) { t->clear_positions(); });
  ExpectRefused(tile, [](auto* t) { t->mutable_normals()->pop_back(); });
  ExpectRefused(tile, [](auto* t) { t->mutable_face_vertices()->pop_back(); });
  ExpectRefused(tile, [](auto* t) { t->mutable_face_vertices()->resize(8); });
  ExpectRefused(tile, [](auto* t) { t->mutable_arities()->append(4, '\0'); });
  ExpectRefused(tile, [](auto* t) { t->set_vertex_count(t->vertex_count() + 1); });
  ExpectRefused(tile, [](auto* t) { t->set_vertex_count(0xffffffff); });
  ExpectRefused(tile, [](auto* t) { t->set_face_count(0xffffffff); });
  ExpectRefused(tile, [](auto* t) { (*t->mutable_arities())[0] = 2; });
  ExpectRefused(tile, [](auto* t) { t->set_arity(4); });
  ExpectRefused(tile, [](auto* t) { t->set_arity(2); });
  ExpectRefused(tile, [](auto* t) { t->set_first_vertex(~0ULL); });
  ExpectRefused(tile, [](auto* t) { t->set_first_face(0xfffffffe); });
  ExpectRefused(tile, [](auto* t) { t->set_encoding(static_cast<v1::MeshEncoding>(12)); });
  // 2^31 faces of 2^31 sides: 2^64 bytes, which is 0 in 64 bits.
  ExpectRefused(tile, [](auto* t) {
    t->clear_arities();
    t->clear_face_vertices();
    t->set_arity(1U << 31);
    t->set_face_count(1U << 31);
  });
}

TEST_F(BrokenTileTest, DracoTilesMustHoldWhatTheyClaim) {
  const v1::SurfaceTile& tile = draco_[0];
  ExpectRefused(tile, [](auto* t) { t->clear_draco(); });
  ExpectRefused(tile, [](auto* t) { t->mutable_draco()->resize(t->draco().size() / 2); });
  ExpectRefused(tile, [](auto* t) { t->set_vertex_count(t->vertex_count() + 1); });
  ExpectRefused(tile, [](auto* t) { t->set_face_count(t->face_count() - 1); });
  ExpectRefused(tile, [](auto* t) { t->set_arity(4); });
}

TEST_F(BrokenTileTest, AssemblerRefusesMissingAndRepeatedTiles) {
  for (const auto& tiles : {packed_, draco_}) {
    ASSERT_GT(tiles.size(), 1U);
    EXPECT_TRUE(Assemble(tiles).ok());
    for (std::size_t missing = 0; missing < tiles.size(); ++missing) {
      auto rest = tiles;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(missing));
      ExpectError(Assemble(rest).status(), Reason::kMalformedEncoding);
      auto twice = tiles;
      twice.push_back(tiles[missing]);
      ExpectError(Assemble(twice).status(), Reason::kMalformedEncoding);
    }
  }
}

TEST_F(BrokenTileTest, AssemblerRefusesFacesOfVerticesThatAreNotThere) {
  auto tiles = packed_;
  const std::uint32_t beyond = static_cast<std::uint32_t>(surface_.vertex_count());
  tiles[0].mutable_face_vertices()->replace(0, 4, reinterpret_cast<const char*>(&beyond), 4);
  ExpectError(Assemble(tiles).status(), Reason::kMalformedEncoding, "faces");
}

TEST_F(BrokenTileTest, AssemblerRefusesNormalsOfSomeTilesOnly) {
  auto tiles = packed_;
  tiles[0].clear_normals();
  ExpectError(Assemble(tiles).status(), Reason::kMalformedEncoding, "normals");
}

TEST_F(BrokenTileTest, AssemblerHoldsTheSurfaceAgainstItsLimits) {
  const std::uint64_t vertices = surface_.vertex_count();
  const std::uint64_t faces = surface_.face_count();
  const auto assemble = [&](std::uint64_t vertex_limit, std::uint64_t face_limit) {
    SurfaceAssembler assembler(vertex_limit, face_limit);
    absl::Status status;
    for (const auto& tile : packed_) status.Update(assembler.Add(tile));
    return status;
  };
  EXPECT_TRUE(assemble(vertices, faces).ok());
  ExpectError(assemble(vertices - 1, faces), Reason::kMalformedEncoding, "vertices");
  ExpectError(assemble(vertices, faces - 1), Reason::kMalformedEncoding, "faces");
}

TEST_F(BrokenTileTest, AssemblerAllocatesNoMoreThanCame) {
  SurfaceAssembler assembler(~0ULL, ~0ULL);
  v1::SurfaceTile tile = packed_[0];
  tile.set_first_vertex(4'000'000'000);
  ASSERT_TRUE(assembler.Add(tile).ok());
  ExpectError(assembler.Finish().status(), Reason::kMalformedEncoding, "vertices");
}

// A prism's caps, at level 0.
TEST(FitLargestFaceTest, TilesGrowForLargeFacesAndTooLargeOnesAreNamedWithARemedy) {
  PolygonMesh mesh;
  const auto polygon = [](Index arity) {
    std::vector<Index> face(arity);
    for (Index i = 0; i < arity; ++i) face[i] = i;
    return face;
  };
  mesh.AddFace(polygon(3));
  TileOptions options;
  ASSERT_TRUE(FitLargestFace(mesh, true, &options).ok());
  EXPECT_EQ(options.tile_bytes, TileOptions{}.tile_bytes);
  mesh.AddFace(polygon(140'000));
  ASSERT_TRUE(FitLargestFace(mesh, true, &options).ok());
  EXPECT_GT(options.tile_bytes, 560'000U);
  options.encoding = v1::MESH_ENCODING_DRACO;
  const absl::Status draco = FitLargestFace(mesh, true, &options);
  EXPECT_EQ(GetErrorDetail(draco)->field, "surface.level");
  EXPECT_EQ(GetErrorDetail(draco)->index, 1U);
  EXPECT_EQ(draco.code(), absl::StatusCode::kInvalidArgument);
  mesh.AddFace(polygon(300'000));
  EXPECT_FALSE(FitLargestFace(mesh, true, &(options = TileOptions{})).ok());
  options.omit_connectivity = true;
  EXPECT_TRUE(FitLargestFace(mesh, true, &options).ok());
}

}  // namespace
}  // namespace limn::wire
