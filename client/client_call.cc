// SPDX-License-Identifier: MIT
#include "client/client_call.h"

#include <chrono>

#include "engine/base/error.h"

namespace limn {

absl::Status CheckClientOptions(const ClientOptions& options) {
  if (options.chunk_bytes == 0 || options.chunk_bytes > wire::kMaxChunkBytes) {
    return MakeError("chunk_bytes is not in [1, 1 MiB]",
                     {.reason = Reason::kInvalidOption, .field = "chunk_bytes"});
  }
  if (options.attempts < 1) {
    return MakeError("attempts is less than 1",
                     {.reason = Reason::kInvalidOption, .field = "attempts"});
  }
  if (!(options.deadline_seconds >= 0)) {
    return MakeError("deadline_seconds is negative or no number",
                     {.reason = Reason::kInvalidOption, .field = "deadline_seconds"});
  }
  return absl::OkStatus();
}

void PrepareCall(const ClientOptions& options, grpc::ClientContext* context) {
  for (const auto& [name, value] : options.metadata) context->AddMetadata(name, value);
  // A century is as good as none, and fits the clock.
  constexpr double kLongest = 3e9;
  if (options.deadline_seconds <= 0 || options.deadline_seconds >= kLongest) return;
  context->set_deadline(std::chrono::system_clock::now() +
                        std::chrono::duration_cast<std::chrono::system_clock::duration>(
                            std::chrono::duration<double>(options.deadline_seconds)));
}

absl::StatusOr<MeshUpload> MeshUpload::Make(v1::InterpolateHeader header, const PolygonMesh& mesh,
                                            const ClientOptions& options) {
  LIMN_RETURN_IF_ERROR(CheckClientOptions(options));
  wire::MeshEncodeOptions encode;
  if (header.mesh().encoding() != v1::MESH_ENCODING_UNSPECIFIED) {
    encode.encoding = header.mesh().encoding();
  }
  if (encode.encoding == v1::MESH_ENCODING_DRACO_QUANTIZED &&
      header.output().quantization_bits() != 0) {
    encode.quantization_bits = static_cast<int>(header.output().quantization_bits());
  }
  encode.any_arity = header.output().repair();
  MeshUpload upload = {.header = std::move(header), .chunk_bytes = options.chunk_bytes};
  LIMN_ASSIGN_OR_RETURN(upload.mesh, wire::EncodeMesh(Context{}, mesh, encode));
  *upload.header.mutable_mesh() = upload.mesh.header;
  return upload;
}

}  // namespace limn
