// SPDX-License-Identifier: MIT
// Tessellated surfaces <-> streams of tiles (limn.v1.SurfaceTile).
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/limit/tessellation.h"
#include "limn/v1/mesh.pb.h"

namespace limn::wire {

struct TileOptions {
  // UNSPECIFIED means PACKED.
  v1::MeshEncoding encoding = v1::MESH_ENCODING_PACKED;
  // Bits per coordinate of MESH_ENCODING_DRACO_QUANTIZED, 8 to 30. All tiles of a surface share one
  // grid, so that a vertex has the same value in every tile that holds it.
  int quantization_bits = 16;
  // Bytes of a tile's arrays before compression at the most, 4 KiB to 1 MiB.
  std::uint32_t tile_bytes = 512U << 10;
  // Leave the connectivity out (packed only).
  bool omit_connectivity = false;
};

// A run of vertices and a run of faces of a tessellation.
struct TileRange {
  std::uint64_t first_vertex = 0;
  std::uint64_t vertex_count = 0;
  std::uint64_t first_face = 0;
  std::uint64_t face_count = 0;
};

// Cuts a surface into tiles that cover every vertex and face exactly once. Errors: INVALID_OPTION.
[[nodiscard]] absl::StatusOr<std::vector<TileRange>> PlanTiles(const Tessellation& surface,
                                                               const TileOptions& options);

// Encodes one tile. Errors: INTERNAL when Draco fails, OUT_OF_MEMORY, CANCELLED.
// Thread-safe: tiles of one surface may be encoded at the same time.
[[nodiscard]] absl::StatusOr<v1::SurfaceTile> EncodeTile(const Context& context,
                                                         const Tessellation& surface,
                                                         const TileRange& range,
                                                         std::uint32_t index,
                                                         const TileOptions& options);

// A decoded tile: vertices by their global numbers.
struct DecodedTile {
  // Global number of each vertex below; empty when they are the run that starts at first_vertex.
  std::vector<std::uint32_t> vertex_ids;
  std::uint64_t first_vertex = 0;
  std::vector<Vec3> positions;
  // As many as positions, or none.
  std::vector<Vec3> normals;
  std::uint64_t first_face = 0;
  // Arity of each face, and the global numbers of its vertices.
  std::vector<std::uint32_t> arities;
  std::vector<std::uint32_t> face_vertices;
};

// Errors: MALFORMED_ENCODING, OUT_OF_MEMORY. Thread-safe.
[[nodiscard]] absl::StatusOr<DecodedTile> DecodeTile(const v1::SurfaceTile& tile);

// Puts a surface together from its tiles, in any order.
class SurfaceAssembler {
 public:
  // vertex_limit, face_limit: more than these is MALFORMED_ENCODING.
  SurfaceAssembler(std::uint64_t vertex_limit, std::uint64_t face_limit);
  [[nodiscard]] absl::Status Add(const v1::SurfaceTile& tile);
  // The surface. Errors: MALFORMED_ENCODING when a vertex or a face is missing. level is the
  // caller's to set.
  [[nodiscard]] absl::StatusOr<Tessellation> Finish();

 private:
  std::uint64_t vertex_limit_;
  std::uint64_t face_limit_;
  std::vector<DecodedTile> tiles_;
};

}  // namespace limn::wire
