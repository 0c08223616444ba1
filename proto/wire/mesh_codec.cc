// SPDX-License-Identifier: MIT
// See mesh_codec.h. Picks the codec; what it must not be asked is checked here.
#include "proto/wire/mesh_codec.h"

#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/guard.h"
#include "proto/wire/draco_decoder.h"
#include "proto/wire/draco_encoder.h"
#include "proto/wire/packed_mesh.h"
#include "proto/wire/polygon_check.h"

namespace limn::wire {
namespace {

constexpr std::uint64_t kDracoSlackBytes = 64 << 10;

v1::MeshEncoding Resolve(v1::MeshEncoding encoding) {
  return encoding == v1::MESH_ENCODING_UNSPECIFIED ? v1::MESH_ENCODING_PACKED : encoding;
}

bool IsDraco(v1::MeshEncoding encoding) {
  return encoding == v1::MESH_ENCODING_DRACO || encoding == v1::MESH_ENCODING_DRACO_QUANTIZED;
}

absl::Status CheckOptions(const MeshEncodeOptions& options) {
  if (!v1::MeshEncoding_IsValid(options.encoding)) {
    return MakeError(absl::StrCat("mesh encoding ", options.encoding, " is not known"),
                     {.reason = Reason::kInvalidOption,
                      .field = "encoding",
                      .remedy = "Use MESH_ENCODING_PACKED"});
  }
  if (options.encoding == v1::MESH_ENCODING_DRACO_QUANTIZED &&
      (options.quantization_bits < kMinQuantizationBits ||
       options.quantization_bits > kMaxQuantizationBits)) {
    return MakeError(
        absl::StrCat("quantization_bits is ", options.quantization_bits),
        {.reason = Reason::kInvalidOption,
         .field = "quantization_bits",
         .remedy = absl::StrCat("Use ", kMinQuantizationBits, " to ", kMaxQuantizationBits)});
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> EncodeBytes(const Context& context, const PolygonMesh& mesh,
                                        const MeshEncodeOptions& options) {
  const v1::MeshEncoding encoding = Resolve(options.encoding);
  if (!IsDraco(encoding)) return EncodePacked(context, mesh);
  const DracoInput input = {.faces = {mesh.vertex_count(), mesh.face_begin, mesh.corner_vertex},
                            .positions = mesh.positions};
  if (encoding == v1::MESH_ENCODING_DRACO) return EncodeDracoLossless(context, input);
  LIMN_ASSIGN_OR_RETURN(const QuantizationGrid grid, FitGrid(context, mesh.positions, {}));
  return EncodeDracoQuantized(context, input, grid, options.quantization_bits);
}

// A claim of the header and what it is held against.
struct Claim {
  const char* field;
  std::uint64_t value;
  std::uint64_t limit;
  // The limit's name, when it is one.
  const char* limit_name = "";
};

absl::Status TooLarge(const Claim& claim) {
  return MakeError(absl::StrCat("the mesh's ", claim.field, " is ", claim.value, "; ", claim.limit,
                                " is the limit"),
                   {.reason = Reason::kLimitExceeded,
                    .field = absl::StrCat("mesh.", claim.field),
                    .remedy = "Send a smaller mesh, or raise the server's limit",
                    .limit = claim.limit_name});
}

absl::Status BadHeader(const char* field, const std::string& message, const std::string& remedy) {
  return MakeError(message, {.reason = Reason::kMalformedRequest,
                             .field = absl::StrCat("mesh.", field),
                             .remedy = remedy});
}

absl::Status CheckCounts(const v1::MeshHeader& header, bool draco, bool any_arity) {
  const std::pair<const char*, std::uint64_t> claims[] = {{"vertex_count", header.vertex_count()},
                                                          {"face_count", header.face_count()},
                                                          {"corner_count", header.corner_count()},
                                                          {"byte_count", header.byte_count()}};
  for (const auto& [field, value] : claims) {
    // Draco bytes know their counts themselves.
    if (value == 0 && (!draco || field == std::string_view("byte_count"))) {
      return BadHeader(field, absl::StrCat("the mesh's ", field, " is 0"), "Set it to 1 or more");
    }
  }
  if (!any_arity && header.face_count() != 0 && header.corner_count() != 0 &&
      header.corner_count() / 3 < header.face_count()) {
    return BadHeader("corner_count",
                     absl::StrCat("the mesh's corner_count is ", header.corner_count(), " for ",
                                  header.face_count(), " faces"),
                     "Set it to the sum of the faces' arities, each 3 or more");
  }
  return absl::OkStatus();
}

absl::Status CheckLimits(const Limits& limits, const v1::MeshHeader& header, bool any_arity) {
  // Numbers of vertices and corners are Index; kNoIndex is none.
  constexpr std::uint64_t kMaxIndex = kNoIndex - 1;
  const std::uint64_t corners = std::min(limits.max_corners, kMaxIndex);
  for (const Claim& claim :
       {Claim{"vertex_count", header.vertex_count(), std::min(limits.max_vertices, kMaxIndex),
              "max-vertices"},
        Claim{"corner_count", header.corner_count(), corners, "max-corners"},
        Claim{"face_count", header.face_count(), any_arity ? corners : corners / 3, "max-corners"},
        Claim{"byte_count", header.byte_count(), limits.max_bytes, "max-job-bytes"}}) {
    if (claim.value > claim.limit) return TooLarge(claim);
  }
  return absl::OkStatus();
}

MeshCounts Counts(const v1::MeshHeader& header) {
  return {header.vertex_count(), header.face_count(), header.corner_count()};
}

// More Draco bytes than any layout of such a mesh takes are junk.
absl::Status CheckDracoSize(const v1::MeshHeader& header) {
  const MeshCounts counts = Counts(header);
  if (counts.vertices == 0 || counts.corners == 0) return absl::OkStatus();
  const std::uint64_t allowed =
      kDracoVertexBytes * counts.vertices + kDracoCornerBytes * counts.corners + kDracoSlackBytes;
  if (header.byte_count() <= allowed) return absl::OkStatus();
  return BadHeader("byte_count",
                   absl::StrCat("the mesh's byte_count is ", header.byte_count(),
                                "; a Draco mesh of its counts takes no more than ", allowed),
                   "Send positions and faces only");
}

absl::Status CheckClaims(const v1::MeshHeader& header, const PolygonMesh& mesh) {
  const Claim claims[] = {{"vertex_count", header.vertex_count(), mesh.vertex_count()},
                          {"face_count", header.face_count(), mesh.face_count()},
                          {"corner_count", header.corner_count(), mesh.corner_count()}};
  for (const Claim& claim : claims) {
    if (claim.value == 0 || claim.value == claim.limit) continue;
    return MakeError(absl::StrCat("the header's ", claim.field, " is ", claim.value,
                                  ", but the Draco mesh has ", claim.limit),
                     {.reason = Reason::kMalformedEncoding,
                      .field = absl::StrCat("mesh.", claim.field),
                      .remedy = "Set it right, or to 0 where it is not known"});
  }
  return absl::OkStatus();
}

absl::StatusOr<PolygonMesh> DecodeDracoMesh(const Context& context, const v1::MeshHeader& header,
                                            std::string_view bytes) {
  const Limits& limits = context.limits();
  const bool claimed = header.face_count() != 0 && header.corner_count() != 0;
  const DracoBounds bounds = {
      .max_vertices = std::min<std::uint64_t>(limits.max_vertices, kNoIndex - 1),
      .max_triangles =
          claimed ? header.corner_count() - 2 * header.face_count() : limits.max_corners,
      .triangles_claimed = claimed,
      .max_bytes = limits.max_bytes};
  LIMN_ASSIGN_OR_RETURN(DracoOutput out, DecodeDraco(context, bytes, bounds));
  if (!out.original_ids.empty()) {
    return MakeError("the original ids of the Draco mesh are not 0, 1, 2 and so on",
                     {.reason = Reason::kMalformedEncoding, .field = "mesh"});
  }
  LIMN_RETURN_IF_ERROR(CheckClaims(header, out.mesh));
  if (out.mesh.corner_count() > limits.max_corners) {
    return TooLarge({"corner_count", out.mesh.corner_count(), limits.max_corners, "max-corners"});
  }
  return std::move(out.mesh);
}

}  // namespace

absl::StatusOr<EncodedMesh> EncodeMesh(const Context& context, const PolygonMesh& mesh,
                                       const MeshEncodeOptions& options) {
  return Guarded("encoding the mesh", Reason::kInternal, [&]() -> absl::StatusOr<EncodedMesh> {
    LIMN_RETURN_IF_ERROR(CheckOptions(options));
    const bool any_arity = options.any_arity && !IsDraco(options.encoding);
    const Index least_arity = any_arity ? 0 : 3;
    LIMN_RETURN_IF_ERROR(CheckPolygons(context, mesh, {.least_arity = least_arity}));
    EncodedMesh encoded;
    LIMN_ASSIGN_OR_RETURN(encoded.bytes, EncodeBytes(context, mesh, options));
    LIMN_RETURN_IF_ERROR(context.Check());
    encoded.header.set_encoding(Resolve(options.encoding));
    encoded.header.set_vertex_count(mesh.vertex_count());
    encoded.header.set_face_count(mesh.face_count());
    encoded.header.set_corner_count(mesh.corner_count());
    encoded.header.set_byte_count(encoded.bytes.size());
    return encoded;
  });
}

absl::Status CheckHeader(const Limits& limits, const v1::MeshHeader& header,
                         const MeshDecodeOptions& options) {
  if (!v1::MeshEncoding_IsValid(header.encoding())) {
    return BadHeader("encoding", absl::StrCat("mesh encoding ", header.encoding(), " is not known"),
                     "Use one of those that GetServerInfo lists");
  }
  const bool draco = IsDraco(header.encoding());
  const bool any_arity = options.any_arity && !draco;
  LIMN_RETURN_IF_ERROR(CheckCounts(header, draco, any_arity));
  LIMN_RETURN_IF_ERROR(CheckLimits(limits, header, any_arity));
  if (draco) return CheckDracoSize(header);
  if (const std::uint64_t packed = PackedBytes(Counts(header)); header.byte_count() != packed) {
    return BadHeader("byte_count",
                     absl::StrCat("the mesh's byte_count is ", header.byte_count(),
                                  ", but its counts need ", packed),
                     "Send 24 bytes per vertex and 4 per face and per corner");
  }
  return absl::OkStatus();
}

absl::StatusOr<PolygonMesh> DecodeMesh(const Context& context, const v1::MeshHeader& header,
                                       std::string_view bytes, const MeshDecodeOptions& options) {
  return Guarded(
      "decoding the mesh", Reason::kMalformedEncoding, [&]() -> absl::StatusOr<PolygonMesh> {
        LIMN_RETURN_IF_ERROR(CheckHeader(context.limits(), header, options));
        if (bytes.size() != header.byte_count()) {
          return MakeError(
              absl::StrCat("the mesh has ", bytes.size(), " bytes, but its header's byte_count is ",
                           header.byte_count()),
              {.reason = Reason::kMalformedEncoding,
               .field = "mesh.byte_count",
               .remedy = "Set byte_count to the sum of the chunks' sizes"});
        }
        LIMN_RETURN_IF_ERROR(context.Check());
        PolygonMesh mesh;
        if (IsDraco(header.encoding())) {
          LIMN_ASSIGN_OR_RETURN(mesh, DecodeDracoMesh(context, header, bytes));
        } else {
          LIMN_ASSIGN_OR_RETURN(mesh, DecodePacked(context, Counts(header), bytes));
        }
        PolygonRules rules = kReceived;
        if (options.any_arity && !IsDraco(header.encoding())) rules.least_arity = 0;
        LIMN_RETURN_IF_ERROR(CheckPolygons(context, mesh, rules));
        return mesh;
      });
}

}  // namespace limn::wire
