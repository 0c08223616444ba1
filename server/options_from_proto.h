// SPDX-License-Identifier: MIT
// The one place that maps a job's header to what the engine and the codec are asked to do. Every
// field is checked; what the contract has and the engine has not answers UNIMPLEMENTED with the
// field's name.
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "engine/filter.h"
#include "engine/interpolate.h"
#include "engine/mesh/repair.h"
#include "limn/v1/interpolate.pb.h"
#include "proto/wire/mesh_codec.h"
#include "proto/wire/tile_codec.h"

namespace limn {

// A checked job.
struct JobSpec {
  // Empty when the client gave none.
  std::string request_id;
  // The mesh's claims; see wire::CheckHeader, which is not called here.
  v1::MeshHeader mesh;
  // `surface` is always set: without one to send, level 0 is computed for the certificate. So are
  // `normals` where some are prescribed.
  InterpolateOptions engine;
  // With it, the mesh is filtered, and the engine interpolates nothing.
  std::optional<FilterOptions> filter;
  // Whether the mesh is repaired first.
  bool repair = false;
  bool send_control_mesh = false;
  bool send_surface = false;
  // With the surface.
  bool send_normals = false;
  wire::MeshEncodeOptions control_mesh;
  wire::TileOptions tiles;

  // Whether the surface may have the mesh's own faces, of any arity.
  bool may_have_level_0() const { return engine.level == 0 || engine.chord_tolerance.has_value(); }
};

// Errors: INVALID_OPTION, INDEX_OUT_OF_RANGE and UNIMPLEMENTED, naming the field as in
// interpolate.proto. Thread-safe.
[[nodiscard]] absl::StatusOr<JobSpec> JobSpecFromProto(const v1::InterpolateHeader& header);

// The job of an Evaluate call: it keeps the surface, and sends nothing of it by itself. Errors: as
// above; INVALID_OPTION for a header that asks for control mesh or surface, or whose mesh is
// quantised.
[[nodiscard]] absl::StatusOr<JobSpec> EvaluateSpecFromProto(const v1::InterpolateHeader& header);

// What the engine did, as the contract says it.
[[nodiscard]] v1::SolveOptions::Method MethodToProto(SolveMethod method);
[[nodiscard]] v1::Scheme SchemeToProto(Scheme scheme);
[[nodiscard]] v1::SolveOptions::Rule RuleToProto(FirstRule rule);
[[nodiscard]] v1::FairnessReport FairnessToProto(const FairnessReport& report);
[[nodiscard]] v1::RepairReport RepairToProto(const RepairReport& report);

}  // namespace limn
