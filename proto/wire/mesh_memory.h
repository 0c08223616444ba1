// SPDX-License-Identifier: MIT
// The memory that encoding and decoding take at their peak, for those who have to set it aside
// before. Upper bounds for meshes and tiles as Limn encodes them, measured with Draco 1.5.5 and
// rounded up; Draco needs more for other programs' attributes beside the position. All saturate at
// numbers that no machine has, and take constant time. Thread-safe.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "limn/v1/mesh.pb.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/packed_mesh.h"
#include "proto/wire/tile_codec.h"

namespace limn::wire {

// Bytes of a PolygonMesh.
[[nodiscard]] std::uint64_t MeshMemory(const MeshCounts& counts);

// Bytes of the longest encoding of such a mesh.
[[nodiscard]] std::uint64_t MostEncodedBytes(const MeshCounts& counts);

// Bytes that EncodeMesh holds beside the mesh, the encoded bytes among them.
[[nodiscard]] std::uint64_t EncodeMemory(const MeshCounts& counts,
                                         const MeshEncodeOptions& options);

// Bytes that DecodeMesh holds beside the encoded bytes, the mesh among them, if the header's counts
// are right. Counts that are not claimed count as 0.
[[nodiscard]] std::uint64_t DecodeMemory(const v1::MeshHeader& header);

// The same by what the encoded bytes say of themselves, which is all that is known of a Draco mesh
// without counts. Errors: MALFORMED_ENCODING.
[[nodiscard]] absl::StatusOr<std::uint64_t> DecodeMemory(const v1::MeshHeader& header,
                                                         std::string_view bytes);

// Bytes that EncodeTile, or DecodeTile of its result, holds for one tile.
[[nodiscard]] std::uint64_t TileMemory(const TileOptions& options);

}  // namespace limn::wire
