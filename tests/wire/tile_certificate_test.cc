// SPDX-License-Identifier: MIT
// A certificate of decoded tiles is one of what the client puts together from them, in every
// encoding, and tells what rounding costs.
#include <algorithm>
#include <random>
#include <vector>

#include "engine/constraints/certificate.h"
#include "proto/wire/tile_codec.h"
#include "tests/wire/test_meshes.h"

namespace limn::wire {
namespace {

constexpr std::uint32_t kSeed = 7;

// A surface through the vertices of a torus of irregular polygons, with random unit normals.
Tessellation MakeSurface() {
  const PolygonMesh mesh = IrregularTorus(40, 30, kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  Tessellation surface;
  surface.positions = mesh.positions;
  surface.face_begin = mesh.face_begin;
  surface.face_vertices = mesh.corner_vertex;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    surface.normals.push_back(
        NormalizedOrZero({coordinate(random), coordinate(random), coordinate(random)}));
  }
  return surface;
}

// Every third vertex of it is met, every sixth with its normal, turned round.
CertificateBuilder MakeBuilder(const Tessellation& surface) {
  Constraints constraints;
  constraints.interpolate.emplace();
  for (Index v = 0; v < surface.vertex_count(); v += 3) {
    constraints.interpolate->push_back(v);
    if (v % 2 == 0) constraints.normals.push_back({v, -2.0 * surface.normals[v]});
  }
  return CertificateBuilder(surface.positions, constraints);
}

struct Certified {
  Certificate tiles;
  Certificate assembled;
};

Certified CertifyBothWays(const Tessellation& surface, TileOptions options) {
  CertificateBuilder of_tiles = MakeBuilder(surface);
  SurfaceAssembler assembler(1 << 20, 1 << 20);
  options.tile_bytes = kMinTileBytes;
  const auto plan = PlanTiles(surface, options);
  EXPECT_TRUE(plan.ok()) << plan.status();
  for (std::uint32_t i = 0; i < plan->size(); ++i) {
    const auto tile = EncodeTile(Context(), surface, (*plan)[i], i, options);
    EXPECT_TRUE(tile.ok()) << tile.status();
    EXPECT_TRUE(assembler.Add(*tile).ok());
    const auto decoded = DecodeTile(*tile);
    EXPECT_TRUE(decoded.ok()) << decoded.status();
    for (std::size_t k = 0; k < decoded->positions.size(); ++k) {
      const std::uint64_t vertex =
          decoded->vertex_ids.empty() ? decoded->first_vertex + k : decoded->vertex_ids[k];
      of_tiles.Add(vertex, decoded->positions[k]);
      of_tiles.AddNormal(vertex, decoded->normals[k]);
    }
  }
  EXPECT_GT(plan->size(), 5U);
  EXPECT_TRUE(of_tiles.complete());
  const auto whole = assembler.Finish();
  EXPECT_TRUE(whole.ok()) << whole.status();
  CertificateBuilder of_whole = MakeBuilder(surface);
  of_whole.AddRun(0, whole->positions);
  of_whole.AddNormalRun(0, whole->normals);
  return {of_tiles.Finish(), of_whole.Finish()};
}

void ExpectSame(const Certificate& a, const Certificate& b) {
  EXPECT_EQ(a.points_checked, b.points_checked);
  EXPECT_EQ(a.max_error, b.max_error);
  EXPECT_EQ(a.mean_error, b.mean_error);
  EXPECT_EQ(a.max_error_vertex, b.max_error_vertex);
  EXPECT_EQ(a.normals_checked, b.normals_checked);
  EXPECT_EQ(a.max_normal_deviation, b.max_normal_deviation);
  EXPECT_EQ(a.max_normal_deviation_vertex, b.max_normal_deviation_vertex);
}

TEST(TileCertificateTest, LosslessTilesKeepPointsAndRoundNormalsToFloat) {
  const Tessellation surface = MakeSurface();
  for (const v1::MeshEncoding encoding : {v1::MESH_ENCODING_PACKED, v1::MESH_ENCODING_DRACO}) {
    const Certified got = CertifyBothWays(surface, {.encoding = encoding});
    ExpectSame(got.tiles, got.assembled);
    EXPECT_EQ(got.tiles.points_checked, (surface.vertex_count() + 2) / 3);
    EXPECT_EQ(got.tiles.normals_checked, (surface.vertex_count() + 5) / 6);
    EXPECT_EQ(got.tiles.max_error, 0);
    EXPECT_GT(got.tiles.max_normal_deviation, 0);
    EXPECT_LT(got.tiles.max_normal_deviation, 1e-7);
  }
}

TEST(TileCertificateTest, QuantisedTilesAreOffByTheirGridAndTheirOctahedron) {
  const Tessellation surface = MakeSurface();
  double last = 1;
  for (const int bits : {10, 14, 18}) {
    const Certified got = CertifyBothWays(
        surface, {.encoding = v1::MESH_ENCODING_DRACO_QUANTIZED, .quantization_bits = bits});
    ExpectSame(got.tiles, got.assembled);
    EXPECT_EQ(got.tiles.points_checked, (surface.vertex_count() + 2) / 3);
    // Half a diagonal of a cube of the grid at the most; the torus is 8 wide.
    const double cube = 8.0 / ((1 << bits) - 1);
    EXPECT_LE(got.tiles.max_error, 0.5 * std::sqrt(3.0) * cube + 1e-6);
    EXPECT_GT(got.tiles.max_error, 0.1 * cube);
    EXPECT_LT(got.tiles.max_error, last);
    last = got.tiles.max_error;
    EXPECT_EQ(got.tiles.normals_checked, (surface.vertex_count() + 5) / 6);
    EXPECT_GT(got.tiles.max_normal_deviation, 1e-5);
    EXPECT_LT(got.tiles.max_normal_deviation, 5e-4);
  }
}

}  // namespace
}  // namespace limn::wire
