// SPDX-License-Identifier: MIT
// One job, from the encoded mesh to the messages of its answer. Knows nothing of gRPC.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/constraints/certificate.h"
#include "engine/interpolate.h"
#include "engine/mesh/repair.h"
#include "limn/v1/interpolate.pb.h"
#include "proto/wire/chunks.h"
#include "proto/wire/repair_mapping.h"
#include "server/options_from_proto.h"

namespace limn {

// First Decode, then Run, then NextMessage until it has no more: the answer is made piece by piece
// as it is asked for, so that a slow reader costs no memory beside the result; only what has to be
// encoded as a whole, the control mesh, is encoded by Run. Not thread-safe, but each call may come
// from another thread.
class Job {
 public:
  // context: carries cancel, deadline, progress and limits through every phase.
  Job(JobSpec spec, Context context);
  ~Job();
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  // A stage that went before Run, for the summary.
  void AddStage(std::string_view stage, double milliseconds);

  // Decodes the mesh; from then on spec() has its counts, claimed or not. Runs in the caller's
  // arena. Errors: those of wire::DecodeMesh.
  [[nodiscard]] absl::Status Decode(std::string encoded_mesh);

  // Repairs the mesh if that was asked for, computes, and encodes the control mesh: all that may
  // take long. Runs in the caller's arena. Errors: those of Repair, Interpolate and
  // wire::EncodeMesh.
  [[nodiscard]] absl::Status Run();

  const JobSpec& spec() const { return spec_; }

  // Fills the next message of the answer: repair, control mesh, tiles, summary. False: there is
  // none left. Cost: linear in a tile. Errors: those of wire::EncodeTile.
  [[nodiscard]] absl::StatusOr<bool> NextMessage(v1::InterpolateResponse* message);

  // The answer begins anew with the next message. Only after Run.
  void Rewind();

  // After Run, the surface itself, if the spec keeps patches. Once.
  std::optional<LimitSurface> TakePatches() { return std::exchange(patches_, std::nullopt); }

  // The stages until now, in order.
  const std::vector<StageTime>& stages() const { return stages_; }
  // Bytes of control mesh and tiles until now.
  std::uint64_t bytes_sent() const { return bytes_sent_; }
  // Of the tessellation: asked for, or chosen once Run has ended.
  std::uint32_t level() const {
    return chord_bound_.has_value() ? spec_.engine.finest : spec_.engine.level;
  }

 private:
  enum class Part { kRepair, kControlHeader, kControlChunks, kTiles, kSummary, kNone };

  [[nodiscard]] absl::Status RepairMesh();
  [[nodiscard]] absl::Status FilterMesh();
  [[nodiscard]] absl::Status Fill(v1::InterpolateResponse* message);
  [[nodiscard]] absl::Status EncodeControlMesh();
  Part FirstPart() const { return mapping_.has_value() ? Part::kRepair : PartAfterRepair(); }
  Part PartAfterRepair() const;
  void NextMappingPiece(v1::RepairReport* piece);
  void NextControlChunk(v1::ControlMeshPart* part);
  [[nodiscard]] absl::Status PlanTiles();
  [[nodiscard]] absl::Status NextTile(v1::SurfaceTile* tile);
  [[nodiscard]] absl::Status Certify(const wire::TileRange& range, const v1::SurfaceTile& tile);
  void FillSummary(v1::Summary* summary);

  JobSpec spec_;
  const Context context_;
  std::vector<StageTime> stages_;
  double encode_milliseconds_ = 0;
  // Of it, what Run took.
  double encode_before_answer_ = 0;
  std::uint64_t bytes_received_ = 0;
  std::uint64_t bytes_sent_ = 0;

  // The input, repaired if that was asked for; after Run with the control mesh's positions.
  PolygonMesh mesh_;
  // What repair says beside the mesh, and the mapping that is still to be sent.
  RepairedMesh repaired_;
  std::optional<wire::MappingReader> mapping_;
  SolveReport solve_;
  FirstRule rule_ = FirstRule::kModified;
  double bilinear_share_ = 0;
  std::optional<double> chord_bound_;
  std::optional<FairnessReport> fairness_;
  std::optional<BlendReport> blend_;
  Tessellation surface_;
  std::optional<LimitSurface> patches_;
  std::optional<CertificateBuilder> certificate_;

  Part part_ = Part::kNone;
  v1::MeshHeader control_header_;
  std::string control_bytes_;
  std::optional<wire::ChunkReader> control_chunks_;
  wire::TileOptions tile_options_;
  std::vector<wire::TileRange> tiles_;
  std::size_t next_tile_ = 0;
};

}  // namespace limn
