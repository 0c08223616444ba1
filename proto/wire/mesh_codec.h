// SPDX-License-Identifier: MIT
// Meshes <-> bytes, the one place where wire meets mesh. Both sides use it. Layouts are those of
// limn.v1.MeshEncoding in proto/limn/v1/mesh.proto.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/mesh.pb.h"

namespace limn::wire {

struct MeshEncodeOptions {
  v1::MeshEncoding encoding = v1::MESH_ENCODING_PACKED;
  // Bits per coordinate of MESH_ENCODING_DRACO_QUANTIZED; see quantization_grid.h.
  int quantization_bits = 16;
  // Lets faces of fewer than 3 corners pass, in a mesh that is to be repaired. PACKED only.
  bool any_arity = false;
};

struct MeshDecodeOptions {
  // As above.
  bool any_arity = false;
};

// Bytes of a Draco mesh that are believed per vertex and per corner: twice what the largest layout
// of positions, fan triangles and arities takes, so that other programs' normals and texture
// coordinates fit too.
inline constexpr std::uint64_t kDracoVertexBytes = 48;
inline constexpr std::uint64_t kDracoCornerBytes = 24;

// A mesh as it travels: the header's counts describe the bytes.
struct EncodedMesh {
  v1::MeshHeader header;
  std::string bytes;
};

// Encodes a mesh. Lossless and order-keeping for PACKED (the default; UNSPECIFIED means it) and
// DRACO; DRACO_QUANTIZED as mesh.proto says.
//
// mesh: indices in range and arities of 3 or more (checked: EMPTY_MESH, INDEX_OUT_OF_RANGE,
// FACE_TOO_SMALL). It need not be manifold for PACKED and DRACO. DRACO_QUANTIZED keeps vertices of
// several fans, but refuses an edge that two faces walk in the same direction (NON_MANIFOLD_EDGE),
// a face that visits a vertex twice (REPEATED_VERTEX), a vertex that no face uses
// (ISOLATED_VERTEX; DRACO too when they outnumber the rest), coordinates beyond float32
// (NON_FINITE_COORDINATE, COORDINATE_TOO_LARGE) and a face that has no triangulation without
// repeating an edge of the mesh (INVALID_OPTION).
//
// Other errors: INVALID_OPTION, LIMIT_EXCEEDED beyond what Draco can say, INTERNAL when Draco
// fails, CANCELLED, DEADLINE_EXCEEDED (see draco_encoder.h and draco_decoder.h),
// OUT_OF_MEMORY. Thread-safe. Cost: linear.
[[nodiscard]] absl::StatusOr<EncodedMesh> EncodeMesh(const Context& context,
                                                     const PolygonMesh& mesh,
                                                     const MeshEncodeOptions& options = {});

// Holds a header's claims against the context's limits, and against each other: a packed mesh's
// byte_count follows from its counts; a Draco mesh must not claim more than kDracoVertexBytes per
// vertex, kDracoCornerBytes per corner and 64 KiB. With a Draco encoding a count of 0 is not
// claimed; then the limits bound what is decoded, and byte_count is held against max_bytes.
// Nothing is allocated. Errors: MALFORMED_REQUEST or LIMIT_EXCEEDED, naming the field
// ("mesh.vertex_count" and so on).
[[nodiscard]] absl::Status CheckHeader(const Limits& limits, const v1::MeshHeader& header,
                                       const MeshDecodeOptions& options = {});

// Decodes what EncodeMesh made, or, for both Draco encodings, a plain triangle mesh of any other
// program: any numeric type of positions, their values being the vertices. Afterwards: counts are
// those that the header claimed and within the limits, every index is in range, every arity is 3
// or more (unless any_arity is set). Coordinates and topology are left to HalfEdgeMesh::Build.
//
// Errors: those of CheckHeader; MALFORMED_ENCODING (field "faces" and the face for a bad index or
// arity); LIMIT_EXCEEDED when a Draco mesh turns out larger than the limits; OUT_OF_MEMORY,
// CANCELLED, DEADLINE_EXCEEDED (see draco_encoder.h and draco_decoder.h). Thread-safe.
// Cost: linear in the mesh, which the number of bytes must justify; see draco_header.h.
[[nodiscard]] absl::StatusOr<PolygonMesh> DecodeMesh(const Context& context,
                                                     const v1::MeshHeader& header,
                                                     std::string_view bytes,
                                                     const MeshDecodeOptions& options = {});

}  // namespace limn::wire
