// SPDX-License-Identifier: MIT
// Puts the messages of a job's answer together.
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/client.h"
#include "limn/v1/interpolate.pb.h"
#include "proto/wire/chunks.h"
#include "proto/wire/repair_mapping.h"
#include "proto/wire/tile_codec.h"

namespace limn {

// Messages in the order in which they came. What a server sends was asked for, so its size has no
// limit but that of indices; memory grows with what has arrived. Not thread-safe.
class ResultCollector {
 public:
  ResultCollector();

  // Errors: INTERNAL for messages that make no sense, and those of the decoders.
  [[nodiscard]] absl::Status Add(v1::InterpolateResponse message);

  // The whole answer, after its last message. Errors: UNREACHABLE when it has no end; INTERNAL when
  // something is missing or is not what the summary says, and those of the decoders. The collector
  // is empty afterwards.
  [[nodiscard]] absl::StatusOr<JobResult> Finish();

 private:
  [[nodiscard]] absl::Status AddControlMesh(const v1::ControlMeshPart& part);

  wire::MappingCollector mapping_;
  v1::MeshHeader control_header_;
  std::optional<wire::ChunkAssembler> control_;
  wire::SurfaceAssembler surface_;
  std::optional<v1::Summary> summary_;
};

}  // namespace limn
