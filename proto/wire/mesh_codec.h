// SPDX-License-Identifier: MIT
// Meshes <-> bytes, the one place where wire meets mesh. Both sides use it. Layouts are those of
// limn.v1.MeshEncoding in proto/limn/v1/mesh.proto.
#pragma once

#include <cstdint>
#include <functional>
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
  // Bits per coordinate of MESH_ENCODING_DRACO_QUANTIZED, 8 to 30.
  int quantization_bits = 16;
};

// A mesh as it travels: the header's counts describe the bytes.
struct EncodedMesh {
  v1::MeshHeader header;
  std::string bytes;
};

// Encodes a mesh. Lossless and order-keeping for PACKED (the default; UNSPECIFIED means it) and
// DRACO; DRACO_QUANTIZED as mesh.proto says.
//
// mesh: indices in range and arities of 3 or more (checked: INDEX_OUT_OF_RANGE, FACE_TOO_SMALL);
// it need not be manifold. Errors: INVALID_OPTION, INTERNAL when Draco fails, CANCELLED,
// DEADLINE_EXCEEDED, OUT_OF_MEMORY. Thread-safe. Cost: linear.
[[nodiscard]] absl::StatusOr<EncodedMesh> EncodeMesh(const Context& context,
                                                     const PolygonMesh& mesh,
                                                     const MeshEncodeOptions& options = {});

// Holds a header's claims against the context's limits, and against each other (a packed mesh's
// byte_count follows from its counts; other encodings must not claim more bytes than packed would
// take plus 64 KiB). Nothing is allocated. Errors: MALFORMED_REQUEST or LIMIT_EXCEEDED, naming the field
// ("mesh.vertex_count" and so on).
[[nodiscard]] absl::Status CheckHeader(const Limits& limits, const v1::MeshHeader& header);

// Decodes what EncodeMesh made, or, for both Draco encodings, a plain triangle mesh of any other
// program. Afterwards: counts are those of the header, every index is in range, every arity is 3
// or more. Coordinates and topology are left to HalfEdgeMesh::Build.
//
// Errors: those of CheckHeader, MALFORMED_ENCODING, OUT_OF_MEMORY, CANCELLED, DEADLINE_EXCEEDED.
// Thread-safe. Cost: linear in the header's counts, which the bytes must justify.
[[nodiscard]] absl::StatusOr<PolygonMesh> DecodeMesh(const Context& context,
                                                     const v1::MeshHeader& header,
                                                     std::string_view bytes);

}  // namespace limn::wire
