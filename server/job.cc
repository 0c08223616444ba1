// SPDX-License-Identifier: MIT
#include "server/job.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "engine/base/error.h"
#include "engine/constraints/renumber.h"
#include "server/job_memory.h"

namespace limn {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Whether one of the faces of the range has a vertex that the certificate counts.
bool Touches(const Tessellation& surface, const wire::TileRange& range,
             const CertificateBuilder& certificate) {
  const auto corner = [&](std::uint64_t face) -> std::uint64_t {
    return surface.arity != 0 ? face * surface.arity : surface.face_begin[face];
  };
  const std::uint64_t begin = corner(range.first_face);
  const std::uint64_t end = corner(range.first_face + range.face_count);
  const auto corners = absl::MakeConstSpan(surface.face_vertices).subspan(begin, end - begin);
  return std::any_of(corners.begin(), corners.end(),
                     [&](Index vertex) { return certificate.counts(vertex); });
}

v1::Certificate CertificateToProto(const Certificate& found) {
  v1::Certificate certificate;
  certificate.set_points_checked(found.points_checked);
  certificate.set_max_error(found.max_error);
  certificate.set_mean_error(found.mean_error);
  certificate.set_bounding_box_diagonal(found.bounding_box_diagonal);
  certificate.set_max_error_vertex(found.max_error_vertex);
  certificate.set_normals_checked(found.normals_checked);
  certificate.set_max_normal_deviation(found.max_normal_deviation);
  certificate.set_max_normal_deviation_vertex(found.max_normal_deviation_vertex);
  return certificate;
}

// Tells the certificate what a decoded tile says.
void CertifyTile(const wire::DecodedTile& tile, CertificateBuilder* certificate) {
  if (tile.vertex_ids.empty()) {
    certificate->AddRun(tile.first_vertex, tile.positions);
    certificate->AddNormalRun(tile.first_vertex, tile.normals);
    return;
  }
  for (std::size_t i = 0; i < tile.vertex_ids.size(); ++i) {
    certificate->Add(tile.vertex_ids[i], tile.positions[i]);
    if (!tile.normals.empty()) certificate->AddNormal(tile.vertex_ids[i], tile.normals[i]);
  }
}

v1::BlendReport BlendToProto(const BlendReport& report) {
  v1::BlendReport proto;
  proto.set_constraints(report.constraints);
  proto.set_together(report.together);
  proto.set_moved_points(report.moved.size());
  proto.set_max_point_error(report.max_point_error);
  proto.set_max_normal_deviation(report.max_normal_deviation);
  proto.set_max_derivative_error(report.max_derivative_error);
  return proto;
}

// An error about a mesh that is not the one that was sent.
absl::Status AfterRepair(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (status.code() != absl::StatusCode::kInvalidArgument || !detail.has_value()) return status;
  absl::string_view message = status.message();
  if (!detail->remedy.empty()) message.remove_suffix(detail->remedy.size() + 2);
  return MakeError(absl::StrCat("after repair: ", message), *detail);
}

}  // namespace

Job::Job(JobSpec spec, Context context)
    : spec_(std::move(spec)), context_(std::move(context)), tile_options_(spec_.tiles) {}

Job::~Job() = default;

void Job::AddStage(std::string_view stage, double milliseconds) {
  stages_.push_back({stage, milliseconds});
}

// Takes the bytes so that they are gone when it returns.
absl::Status Job::Decode(std::string encoded_mesh) {  // NOLINT(performance-unnecessary-value-param)
  const Clock::time_point start = Clock::now();
  bytes_received_ = encoded_mesh.size();
  context_.Report({.stage = "decode"});
  LIMN_ASSIGN_OR_RETURN(
      mesh_, wire::DecodeMesh(context_, spec_.mesh, encoded_mesh, {.any_arity = spec_.repair}));
  spec_.mesh.set_vertex_count(mesh_.vertex_count());
  spec_.mesh.set_face_count(mesh_.face_count());
  spec_.mesh.set_corner_count(mesh_.corner_count());
  FitFinestLevel(context_.limits(), &spec_);
  AddStage("decode", MillisecondsSince(start));
  return absl::OkStatus();
}

absl::Status Job::Run() {
  if (spec_.repair) LIMN_RETURN_IF_ERROR(RepairMesh());
  if (spec_.filter.has_value()) LIMN_RETURN_IF_ERROR(FilterMesh());
  if (spec_.send_surface && spec_.may_have_level_0()) {
    LIMN_RETURN_IF_ERROR(wire::FitLargestFace(mesh_, spec_.engine.normals, &tile_options_));
  }

  absl::StatusOr<InterpolateResult> interpolated = Interpolate(context_, mesh_, spec_.engine);
  if (!interpolated.ok() && mapping_.has_value()) return AfterRepair(interpolated.status());
  LIMN_ASSIGN_OR_RETURN(InterpolateResult result, std::move(interpolated));
  stages_.insert(stages_.end(), result.stages.begin(), result.stages.end());
  solve_ = result.solve;
  rule_ = result.rule;
  bilinear_share_ = result.bilinear_share;
  chord_bound_ = result.chord_bound;
  if (chord_bound_.has_value()) spec_.engine.finest = result.surface.level;
  fairness_ = result.fairness;
  blend_ = std::move(result.blend);
  surface_ = std::move(result.surface);
  patches_ = std::move(result.patches);
  certificate_.emplace(std::exchange(mesh_.positions, std::move(result.control_positions)),
                       spec_.engine.constraints);
  if (!spec_.send_normals) {
    certificate_->AddNormalRun(0, surface_.normals);
    Buffer<Vec3>().swap(surface_.normals);
  }
  if (spec_.send_surface) {
    LIMN_RETURN_IF_ERROR(PlanTiles());
  } else {
    certificate_->AddRun(0, surface_.positions);
    surface_ = Tessellation{};
  }
  if (spec_.send_control_mesh) LIMN_RETURN_IF_ERROR(EncodeControlMesh());
  mesh_ = PolygonMesh{};
  encode_before_answer_ = encode_milliseconds_;
  part_ = FirstPart();
  return absl::OkStatus();
}

// Told twice of the same points, the certificate stays as it is.
void Job::Rewind() {
  if (mapping_.has_value()) {
    mapping_.emplace(repaired_.original_vertex, repaired_.original_face, tile_options_.tile_bytes);
  }
  if (spec_.send_control_mesh) control_chunks_.emplace(control_bytes_, tile_options_.tile_bytes);
  next_tile_ = 0;
  bytes_sent_ = 0;
  encode_milliseconds_ = encode_before_answer_;
  part_ = FirstPart();
}

absl::Status Job::FilterMesh() {
  const Clock::time_point start = Clock::now();
  absl::StatusOr<Buffer<Vec3>> points = Filter(context_, mesh_, *spec_.filter, spec_.engine);
  if (!points.ok() && mapping_.has_value()) return AfterRepair(points.status());
  LIMN_ASSIGN_OR_RETURN(mesh_.positions, std::move(points));
  AddStage("filter", MillisecondsSince(start));
  return absl::OkStatus();
}

// Constraints name vertices of the mesh that was sent.
absl::Status Job::RepairMesh() {
  const Clock::time_point start = Clock::now();
  Constraints& constraints = spec_.engine.constraints;
  LIMN_RETURN_IF_ERROR(ValidateConstraints(context_, constraints, mesh_.vertex_count()));
  LIMN_ASSIGN_OR_RETURN(repaired_, Repair(context_, mesh_));
  mesh_ = std::exchange(repaired_.mesh, PolygonMesh{});
  if (repaired_.report != RepairReport()) {
    mapping_.emplace(repaired_.original_vertex, repaired_.original_face, tile_options_.tile_bytes);
    LIMN_ASSIGN_OR_RETURN(constraints,
                          RenumberConstraints(context_, constraints,
                                              {.vertex = repaired_.original_vertex,
                                               .face = repaired_.original_face,
                                               .vertex_count = spec_.mesh.vertex_count(),
                                               .face_count = spec_.mesh.face_count()}));
  }
  AddStage("repair", MillisecondsSince(start));
  return absl::OkStatus();
}

absl::StatusOr<bool> Job::NextMessage(v1::InterpolateResponse* message) {
  if (part_ == Part::kNone) return false;
  LIMN_RETURN_IF_ERROR(context_.Check());
  const Clock::time_point start = Clock::now();
  LIMN_RETURN_IF_ERROR(Fill(message));
  encode_milliseconds_ += MillisecondsSince(start);
  // Last of all, so that it knows the time of everything before it.
  if (message->has_summary()) FillSummary(message->mutable_summary());
  return true;
}

absl::Status Job::Fill(v1::InterpolateResponse* message) {
  switch (part_) {
    case Part::kRepair:
      NextMappingPiece(message->mutable_repair());
      return absl::OkStatus();
    case Part::kControlHeader:
      *message->mutable_control_mesh()->mutable_header() = control_header_;
      part_ = Part::kControlChunks;
      return absl::OkStatus();
    case Part::kControlChunks:
      NextControlChunk(message->mutable_control_mesh());
      return absl::OkStatus();
    case Part::kTiles:
      return NextTile(message->mutable_tile());
    case Part::kSummary:
      message->mutable_summary();
      part_ = Part::kNone;
      return absl::OkStatus();
    case Part::kNone:
      break;
  }
  return absl::OkStatus();
}

Job::Part Job::PartAfterRepair() const {
  if (spec_.send_control_mesh) return Part::kControlHeader;
  return tiles_.empty() ? Part::kSummary : Part::kTiles;
}

void Job::NextMappingPiece(v1::RepairReport* piece) {
  mapping_->Next(piece);
  bytes_sent_ += piece->original_vertex().size() + piece->original_face().size();
  if (mapping_->has_next()) return;
  part_ = PartAfterRepair();
}

absl::Status Job::EncodeControlMesh() {
  const Clock::time_point start = Clock::now();
  context_.Report({.stage = "encode"});
  LIMN_ASSIGN_OR_RETURN(wire::EncodedMesh encoded,
                        wire::EncodeMesh(context_, mesh_, spec_.control_mesh));
  control_header_ = std::move(encoded.header);
  control_bytes_ = std::move(encoded.bytes);
  control_chunks_.emplace(control_bytes_, tile_options_.tile_bytes);
  encode_milliseconds_ += MillisecondsSince(start);
  return absl::OkStatus();
}

void Job::NextControlChunk(v1::ControlMeshPart* part) {
  control_chunks_->Next(part->mutable_chunk());
  bytes_sent_ += part->chunk().data().size();
  if (!part->chunk().last()) return;
  part_ = tiles_.empty() ? Part::kSummary : Part::kTiles;
}

absl::Status Job::PlanTiles() {
  LIMN_ASSIGN_OR_RETURN(tiles_, wire::PlanTiles(surface_, tile_options_));
  if (tile_options_.encoding == v1::MESH_ENCODING_DRACO_QUANTIZED) {
    // Once for all tiles, which would otherwise look at the whole surface each.
    LIMN_ASSIGN_OR_RETURN(tile_options_.grid,
                          wire::FitGrid(context_, surface_.positions, surface_.normals));
  }
  return absl::OkStatus();
}

absl::Status Job::NextTile(v1::SurfaceTile* tile) {
  const wire::TileRange& range = tiles_[next_tile_];
  LIMN_ASSIGN_OR_RETURN(
      *tile, wire::EncodeTile(context_, surface_, range, static_cast<std::uint32_t>(next_tile_),
                              tile_options_));
  LIMN_RETURN_IF_ERROR(Certify(range, *tile));
  bytes_sent_ += tile->positions().size() + tile->normals().size() + tile->face_vertices().size() +
                 tile->arities().size() + tile->draco().size();
  if (++next_tile_ == tiles_.size()) part_ = Part::kSummary;
  return absl::OkStatus();
}

// What the client will have. The positions of a packed tile are the very doubles; its normals, and
// all of any other tile, are decoded again.
absl::Status Job::Certify(const wire::TileRange& range, const v1::SurfaceTile& tile) {
  const bool packed = tile.encoding() == v1::MESH_ENCODING_PACKED;
  const bool normals = spec_.send_normals && !spec_.engine.constraints.normals.empty();
  if (packed && !normals) {
    certificate_->AddRun(
        range.first_vertex,
        absl::MakeConstSpan(surface_.positions).subspan(range.first_vertex, range.vertex_count));
    return absl::OkStatus();
  }
  const bool touches = packed ? range.first_vertex < certificate_->target_count()
                              : Touches(surface_, range, *certificate_);
  if (!touches) return absl::OkStatus();
  LIMN_ASSIGN_OR_RETURN(const wire::DecodedTile decoded, wire::DecodeTile(tile));
  CertifyTile(decoded, &*certificate_);
  return absl::OkStatus();
}

void Job::FillSummary(v1::Summary* summary) {
  if (stages_.back().stage != "encode") AddStage("encode", 0);
  stages_.back().milliseconds = encode_milliseconds_;
  summary->set_request_id(spec_.request_id);
  summary->set_server_version(LIMN_VERSION);
  summary->set_scheme(SchemeToProto(spec_.engine.scheme));
  summary->set_input_vertices(spec_.mesh.vertex_count());
  summary->set_input_faces(spec_.mesh.face_count());
  summary->set_level(spec_.send_surface ? surface_.level : spec_.engine.level);
  if (spec_.send_surface) {
    summary->set_surface_vertices(surface_.vertex_count());
    summary->set_surface_faces(surface_.face_count());
  }
  v1::SolveReport* solve = summary->mutable_solve();
  solve->set_method(MethodToProto(solve_.method));
  solve->set_rule(RuleToProto(rule_));
  solve->set_bilinear_share(bilinear_share_);
  solve->set_least_eigenvalue(solve_.least_eigenvalue);
  solve->set_sweeps(solve_.sweeps);
  solve->set_converged(solve_.converged);
  solve->set_last_update(solve_.last_update);
  solve->set_residual(solve_.residual);

  *summary->mutable_certificate() = CertificateToProto(certificate_->Finish());
  summary->mutable_certificate()->set_after_encoding(spec_.send_surface);

  if (chord_bound_.has_value()) summary->set_chord_bound(*chord_bound_);
  if (fairness_.has_value()) *summary->mutable_fairness() = FairnessToProto(*fairness_);
  if (blend_.has_value()) *summary->mutable_blend() = BlendToProto(*blend_);
  if (spec_.repair) *summary->mutable_repair() = RepairToProto(repaired_.report);

  for (const StageTime& stage : stages_) {
    v1::StageTime* entry = summary->add_stages();
    entry->set_stage(std::string(stage.stage));
    entry->set_milliseconds(stage.milliseconds);
  }
  summary->set_bytes_received(bytes_received_);
  summary->set_bytes_sent(bytes_sent_);
}

}  // namespace limn
