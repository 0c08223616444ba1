// SPDX-License-Identifier: MIT
// Tessellated surfaces <-> streams of tiles (limn.v1.SurfaceTile).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/limit/tessellation.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/mesh.pb.h"
#include "proto/wire/quantization_grid.h"

namespace limn::wire {

// Bytes that TileOptions.tile_bytes may be.
inline constexpr std::uint32_t kMinTileBytes = 4U << 10;
inline constexpr std::uint32_t kMaxTileBytes = 1U << 20;

struct TileOptions {
  // UNSPECIFIED means PACKED.
  v1::MeshEncoding encoding = v1::MESH_ENCODING_PACKED;
  // Bits per coordinate of MESH_ENCODING_DRACO_QUANTIZED; see quantization_grid.h. All tiles of a
  // surface share one grid, so that a vertex has the same value in every tile that holds it.
  int quantization_bits = 16;
  // Bytes of a tile's arrays before compression at the most, kMinTileBytes to kMaxTileBytes.
  std::uint32_t tile_bytes = 512U << 10;
  // Leave the connectivity out (packed only).
  bool omit_connectivity = false;
  // The surface's grid, for MESH_ENCODING_DRACO_QUANTIZED: FitGrid(context, surface.positions,
  // surface.normals), found once. Without it EncodeTile finds it anew for every tile, which gives
  // the same bytes but costs a pass over the whole surface each time.
  std::optional<QuantizationGrid> grid;
};

// A run of vertices and a run of faces of a tessellation.
struct TileRange {
  std::uint64_t first_vertex = 0;
  std::uint64_t vertex_count = 0;
  std::uint64_t first_face = 0;
  std::uint64_t face_count = 0;

  friend bool operator==(const TileRange&, const TileRange&) = default;
};

// Cuts a surface into tiles that cover every face exactly once, and every vertex: exactly once by
// the runs of PACKED; with the faces that use it by the Draco encodings, whose runs of vertices are
// empty. With omit_connectivity the runs of faces are empty. No tile for an empty surface.
//
// Errors: INVALID_OPTION, naming the option; LIMIT_EXCEEDED (field "faces", its index) for a face
// that alone is larger than tile_bytes. Cost: linear in tiles; in faces where arities differ.
[[nodiscard]] absl::StatusOr<std::vector<TileRange>> PlanTiles(const Tessellation& surface,
                                                               const TileOptions& options);

// For tiles with the mesh's own faces (level 0): raises options->tile_bytes as far as its largest
// face needs. Errors: INVALID_OPTION (field "surface.level") for a face that no tile can hold.
// Cost: one pass over faces.
[[nodiscard]] absl::Status FitLargestFace(const PolygonMesh& mesh, bool normals,
                                          TileOptions* options);

// Encodes one tile of the plan. Errors: INVALID_OPTION, as PlanTiles and for a range beyond the
// surface; those of FitGrid; INTERNAL when Draco fails, OUT_OF_MEMORY, CANCELLED,
// DEADLINE_EXCEEDED. Thread-safe: tiles of one surface may be encoded at the same time.
[[nodiscard]] absl::StatusOr<v1::SurfaceTile> EncodeTile(const Context& context,
                                                         const Tessellation& surface,
                                                         const TileRange& range,
                                                         std::uint32_t index,
                                                         const TileOptions& options);

// A decoded tile: vertices by their global numbers.
struct DecodedTile {
  // Global number of each vertex below, ascending; empty when they are the run that starts at
  // first_vertex.
  std::vector<std::uint32_t> vertex_ids;
  std::uint64_t first_vertex = 0;
  // Whether no other tile may bring these vertices (packed), or neighbours may too (Draco).
  bool is_run = true;
  std::vector<Vec3> positions;
  // As many as positions, or none.
  std::vector<Vec3> normals;
  std::uint64_t first_face = 0;
  // Arity of each face, and the global numbers of its vertices.
  std::vector<std::uint32_t> arities;
  std::vector<std::uint32_t> face_vertices;
};

// Afterwards arrays are as long as they say of each other, and every corner of a Draco tile names a
// vertex of the tile; corners of a packed tile may name vertices of other tiles. Errors:
// MALFORMED_ENCODING, OUT_OF_MEMORY. Thread-safe.
[[nodiscard]] absl::StatusOr<DecodedTile> DecodeTile(const v1::SurfaceTile& tile);

// Puts a surface together from its tiles, in any order. A vertex that comes with several Draco
// tiles is taken from the one that has the smallest first_face; they all say the same.
class SurfaceAssembler {
 public:
  // vertex_limit, face_limit: more than these is MALFORMED_ENCODING.
  SurfaceAssembler(std::uint64_t vertex_limit, std::uint64_t face_limit);
  // Decodes a tile and keeps it. Errors: those of DecodeTile; MALFORMED_ENCODING beyond the
  // limits. Memory grows with what has arrived.
  [[nodiscard]] absl::Status Add(const v1::SurfaceTile& tile);
  // The surface; without faces when no tile brought any. Errors: MALFORMED_ENCODING when a vertex
  // or a face is missing or comes twice, when a face names a vertex that is not there, when some
  // tiles have normals and others have not; OUT_OF_MEMORY. level is the caller's to set. Faces of
  // one arity give that arity, others face_begin. The assembler is empty afterwards.
  [[nodiscard]] absl::StatusOr<Tessellation> Finish();

 private:
  std::uint64_t vertex_limit_;
  std::uint64_t face_limit_;
  std::uint64_t corners_ = 0;
  std::uint64_t faces_ = 0;
  std::vector<DecodedTile> tiles_;
};

}  // namespace limn::wire
