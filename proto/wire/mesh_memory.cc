// SPDX-License-Identifier: MIT
// See mesh_memory.h.
#include "proto/wire/mesh_memory.h"

#include <algorithm>

#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "proto/wire/draco_header.h"
#include "proto/wire/quantization_grid.h"

namespace limn::wire {
namespace {

// Small arrays and the rounding of small numbers.
constexpr std::uint64_t kSlack = 64 << 10;

std::uint64_t BufferOf(std::uint64_t bytes) {
  return static_cast<std::uint64_t>(BufferBytes(static_cast<double>(bytes)));
}

// Triangles that the faces are cut into; for counts that do not fit, none.
std::uint64_t Triangles(const MeshCounts& counts) {
  return counts.corners - std::min(counts.corners, 2 * counts.faces);
}

bool IsDraco(v1::MeshEncoding encoding) {
  return encoding == v1::MESH_ENCODING_DRACO || encoding == v1::MESH_ENCODING_DRACO_QUANTIZED;
}

// Sequential: the triangles, the values, and the growing output, which is held three times while
// it moves: 24 bytes per vertex, 16 per triangle and its arity.
std::uint64_t LosslessMemory(std::uint64_t vertices, std::uint64_t triangles) {
  return 100 * vertices + 75 * triangles + kSlack;
}

// Edgebreaker: the table of edges of the triangulation, Draco's table of corners, one more for each
// attribute, symbols, the values; and the entropy coder's table of all numbers that occur, which
// is as long as quantised coordinates and vertex numbers are large.
std::uint64_t QuantizedMemory(std::uint64_t vertices, std::uint64_t triangles, int bits) {
  const std::uint64_t numbers = std::uint64_t{1} << std::min(bits, kUsefulQuantizationBits);
  return 120 * vertices + 280 * triangles + 5 * numbers + kSlack;
}

std::uint64_t EncodedMemory(const MeshCounts& counts, v1::MeshEncoding encoding, int bits) {
  if (!IsDraco(encoding)) return PackedBytes(counts);
  return encoding == v1::MESH_ENCODING_DRACO
             ? LosslessMemory(counts.vertices, Triangles(counts))
             : QuantizedMemory(counts.vertices, Triangles(counts), bits);
}

MeshCounts Counts(const v1::MeshHeader& header) {
  return {header.vertex_count(), header.face_count(), header.corner_count()};
}

}  // namespace

std::uint64_t MeshMemory(const MeshCounts& counts) {
  return BufferOf(counts.vertices * sizeof(Vec3)) + BufferOf((counts.faces + 1) * sizeof(Index)) +
         BufferOf(counts.corners * sizeof(Index));
}

std::uint64_t MostEncodedBytes(const MeshCounts& counts) {
  return std::max(PackedBytes(counts), 24 * counts.vertices + 16 * Triangles(counts) + kSlack);
}

std::uint64_t EncodeMemory(const MeshCounts& counts, const MeshEncodeOptions& options) {
  return EncodedMemory(counts, options.encoding, options.quantization_bits);
}

std::uint64_t DecodeMemory(const v1::MeshHeader& header) {
  const MeshCounts counts = Counts(header);
  if (!IsDraco(header.encoding())) return MeshMemory(counts);
  // With splits, and two attributes that have a connectivity of their own, as Limn's have.
  const bool quantized = header.encoding() == v1::MESH_ENCODING_DRACO_QUANTIZED;
  const DracoHeader draco = {.edgebreaker = quantized,
                             .triangles = Triangles(counts),
                             .vertices = counts.vertices + (quantized ? counts.vertices / 8 : 0),
                             .attribute_connectivities = quantized ? 2U : 0U};
  return DracoDecodeBytes(draco) + kSlack;
}

absl::StatusOr<std::uint64_t> DecodeMemory(const v1::MeshHeader& header, std::string_view bytes) {
  if (!IsDraco(header.encoding())) return DecodeMemory(header);
  LIMN_ASSIGN_OR_RETURN(const DracoHeader draco, ReadDracoHeader(bytes));
  return std::max(DracoDecodeBytes(draco) + kSlack, DecodeMemory(header));
}

std::uint64_t TileMemory(const TileOptions& options) {
  if (!IsDraco(options.encoding)) return options.tile_bytes;
  // A corner of a Draco tile takes 32 bytes and more, a triangle at least 68.
  const MeshCounts most = {.vertices = options.tile_bytes / 32};
  const std::uint64_t triangles = options.tile_bytes / 68;
  return 2 * options.tile_bytes +
         (options.encoding == v1::MESH_ENCODING_DRACO
              ? LosslessMemory(most.vertices, triangles)
              : QuantizedMemory(most.vertices, triangles, options.quantization_bits));
}

}  // namespace limn::wire
