// SPDX-License-Identifier: MIT
#include "server/options_from_proto.h"

#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kMaxRequestIdBytes = 128;
constexpr std::uint32_t kMostLevels = 10;
constexpr std::uint32_t kMostSweeps = 10'000;
constexpr std::uint32_t kLeastTileBytes = 4U << 10;
constexpr std::uint32_t kMostTileBytes = 1U << 20;

absl::Status Invalid(absl::string_view field, absl::string_view message, absl::string_view remedy) {
  return MakeError(absl::StrCat(field, ": ", message), {.reason = Reason::kInvalidOption,
                                                        .field = std::string(field),
                                                        .remedy = std::string(remedy)});
}

absl::Status NotBuilt(absl::string_view field, absl::string_view feature,
                      absl::string_view remedy) {
  return MakeError(absl::StrCat(field, ": ", feature, " not implemented yet"),
                   {.reason = Reason::kUnimplemented,
                    .field = std::string(field),
                    .remedy = std::string(remedy)});
}

absl::Status UnknownValue(absl::string_view field, int value) {
  return Invalid(field, absl::StrCat(value, " is no value of this enumeration"),
                 "Use one of the values in the contract");
}

absl::Status CheckRequestId(const std::string& id) {
  if (id.size() > kMaxRequestIdBytes) {
    return Invalid("request_id", absl::StrCat("it has ", id.size(), " characters"),
                   absl::StrCat("Use at most ", kMaxRequestIdBytes));
  }
  for (const char c : id) {
    if (!absl::ascii_isgraph(static_cast<unsigned char>(c))) {
      return Invalid("request_id", "it has characters outside visible ASCII",
                     "Use letters, digits and signs without spaces");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckScheme(v1::Scheme scheme) {
  switch (scheme) {
    case v1::SCHEME_UNSPECIFIED:
    case v1::SCHEME_DOO_SABIN:
      return absl::OkStatus();
    case v1::SCHEME_CATMULL_CLARK:
      return NotBuilt("scheme", "Catmull-Clark surfaces are", "Use SCHEME_DOO_SABIN");
    case v1::SCHEME_LOOP:
      return NotBuilt("scheme", "Loop surfaces are", "Use SCHEME_DOO_SABIN");
    default:
      return UnknownValue("scheme", scheme);
  }
}

absl::Status CheckEncoding(absl::string_view field, v1::MeshEncoding encoding) {
  if (v1::MeshEncoding_IsValid(encoding)) return absl::OkStatus();
  return UnknownValue(field, encoding);
}

absl::Status CheckConstraints(const v1::Constraints& constraints) {
  struct Kind {
    bool used;
    absl::string_view field;
    absl::string_view feature;
  };
  const Kind kinds[] = {
      {constraints.has_interpolate(), "constraints.interpolate", "subsets of vertices are"},
      {constraints.normals_size() > 0, "constraints.normals", "prescribed normals are"},
      {constraints.shape_handles_size() > 0, "constraints.shape_handles", "shape handles are"},
      {constraints.surface_points_size() > 0, "constraints.surface_points",
       "constraints at points of the surface are"},
      {constraints.creases_size() > 0, "constraints.creases", "creases are"},
      {constraints.corners_size() > 0, "constraints.corners", "sharp vertices are"},
      {constraints.holes_size() > 0, "constraints.holes", "holes are"},
      {constraints.has_features(), "constraints.features", "feature values are"},
  };
  for (const Kind& kind : kinds) {
    if (kind.used) {
      return NotBuilt(kind.field, kind.feature, "Leave it out: all vertices are interpolated");
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<SolveMethod> MethodFromProto(v1::SolveOptions::Method method) {
  switch (method) {
    case v1::SolveOptions::METHOD_UNSPECIFIED:
    case v1::SolveOptions::METHOD_CHEBYSHEV:
      return SolveMethod::kChebyshev;
    case v1::SolveOptions::METHOD_JACOBI:
      return SolveMethod::kJacobi;
    case v1::SolveOptions::METHOD_GAUSS_SEIDEL:
      return SolveMethod::kGaussSeidel;
    case v1::SolveOptions::METHOD_CONJUGATE_GRADIENT:
      return NotBuilt("solve.method", "conjugate gradients are", "Use METHOD_CHEBYSHEV");
    default:
      return UnknownValue("solve.method", method);
  }
}

absl::Status CheckRule(v1::SolveOptions::Rule rule) {
  switch (rule) {
    case v1::SolveOptions::RULE_UNSPECIFIED:
    case v1::SolveOptions::RULE_MODIFIED:
      return absl::OkStatus();
    case v1::SolveOptions::RULE_STANDARD:
      return NotBuilt("solve.rule", "the scheme's own first refinement rule is",
                      "Use RULE_MODIFIED");
    case v1::SolveOptions::RULE_BILINEAR_FIRST_STEP:
      return NotBuilt("solve.rule", "the bilinear first refinement rule is", "Use RULE_MODIFIED");
    default:
      return UnknownValue("solve.rule", rule);
  }
}

absl::StatusOr<SolveOptions> SolveFromProto(const v1::SolveOptions& solve) {
  SolveOptions options;
  LIMN_ASSIGN_OR_RETURN(options.method, MethodFromProto(solve.method()));
  LIMN_RETURN_IF_ERROR(CheckRule(solve.rule()));
  if (solve.fair()) {
    return NotBuilt("solve.fair", "fairing is", "Leave it off");
  }
  if (solve.has_tolerance()) {
    // Written so that NaN is refused.
    if (!(solve.tolerance() >= 0 && solve.tolerance() < 1)) {
      return Invalid("solve.tolerance", absl::StrCat(solve.tolerance(), " is not in [0, 1)"),
                     "It is a part of the bounding box's diagonal, such as 1e-12");
    }
    options.tolerance = solve.tolerance();
  }
  if (solve.has_max_sweeps()) {
    if (solve.max_sweeps() > kMostSweeps) {
      return Invalid("solve.max_sweeps", absl::StrCat(solve.max_sweeps(), " is too many"),
                     absl::StrCat("Use at most ", kMostSweeps));
    }
    options.max_sweeps = solve.max_sweeps();
  }
  return options;
}

absl::Status ReadSurface(const v1::SurfaceOptions& surface, InterpolateOptions* options) {
  if (surface.fineness_case() == v1::SurfaceOptions::kChordTolerance) {
    return NotBuilt("surface.chord_tolerance", "tessellation to a chord tolerance is",
                    "Use surface.level");
  }
  if (surface.fineness_case() == v1::SurfaceOptions::kLevel) {
    if (surface.level() > kMostLevels) {
      return Invalid("surface.level", absl::StrCat(surface.level(), " is too many refinements"),
                     absl::StrCat("Use at most ", kMostLevels));
    }
    options->level = surface.level();
  }
  if (!v1::SurfaceOptions::Boundary_IsValid(surface.boundary())) {
    return UnknownValue("surface.boundary", surface.boundary());
  }
  if (surface.boundary() != v1::SurfaceOptions::BOUNDARY_UNSPECIFIED) {
    return NotBuilt("surface.boundary", "boundary rules are", "Leave it out");
  }
  return absl::OkStatus();
}

absl::Status CheckOutput(const v1::OutputOptions& output) {
  LIMN_RETURN_IF_ERROR(CheckEncoding("output.encoding", output.encoding()));
  const std::uint32_t bits = output.quantization_bits();
  if (bits != 0 && (bits < 8 || bits > 30)) {
    return Invalid("output.quantization_bits", absl::StrCat(bits, " is not in [8, 30]"),
                   "Leave it 0 for the default");
  }
  const std::uint32_t bytes = output.tile_bytes();
  if (bytes != 0 && (bytes < kLeastTileBytes || bytes > kMostTileBytes)) {
    return Invalid("output.tile_bytes",
                   absl::StrCat(bytes, " is not in [", kLeastTileBytes, ", ", kMostTileBytes, "]"),
                   "Leave it 0 for the default");
  }
  const bool draco = output.encoding() == v1::MESH_ENCODING_DRACO ||
                     output.encoding() == v1::MESH_ENCODING_DRACO_QUANTIZED;
  if (output.omit_connectivity() && draco) {
    return Invalid("output.omit_connectivity", "a Draco surface cannot go without connectivity",
                   "Use MESH_ENCODING_PACKED for it");
  }
  return absl::OkStatus();
}

void ReadOutput(const v1::OutputOptions& output, JobSpec* spec) {
  spec->send_control_mesh = output.control_mesh();
  spec->send_surface = output.surface();
  spec->repair = output.repair();
  spec->engine.surface = true;
  spec->engine.normals = output.surface() && output.normals();
  if (!output.surface()) spec->engine.level = 0;
  if (output.encoding() != v1::MESH_ENCODING_UNSPECIFIED) {
    spec->control_mesh.encoding = output.encoding();
    spec->tiles.encoding = output.encoding();
  }
  if (output.quantization_bits() != 0) {
    spec->control_mesh.quantization_bits = static_cast<int>(output.quantization_bits());
    spec->tiles.quantization_bits = static_cast<int>(output.quantization_bits());
  }
  if (output.tile_bytes() != 0) spec->tiles.tile_bytes = output.tile_bytes();
  spec->tiles.omit_connectivity = output.omit_connectivity();
}

}  // namespace

absl::StatusOr<JobSpec> JobSpecFromProto(const v1::InterpolateHeader& header) {
  JobSpec spec;
  LIMN_RETURN_IF_ERROR(CheckRequestId(header.request_id()));
  spec.request_id = header.request_id();
  LIMN_RETURN_IF_ERROR(CheckScheme(header.scheme()));
  if (!header.has_mesh()) {
    return Invalid("mesh", "the header does not describe the mesh that follows",
                   "Set the counts and the encoding of the mesh");
  }
  LIMN_RETURN_IF_ERROR(CheckEncoding("mesh.encoding", header.mesh().encoding()));
  spec.mesh = header.mesh();
  if (spec.mesh.encoding() == v1::MESH_ENCODING_UNSPECIFIED) {
    spec.mesh.set_encoding(v1::MESH_ENCODING_PACKED);
  }
  LIMN_RETURN_IF_ERROR(CheckConstraints(header.constraints()));
  LIMN_ASSIGN_OR_RETURN(spec.engine.solve, SolveFromProto(header.solve()));
  LIMN_RETURN_IF_ERROR(ReadSurface(header.surface(), &spec.engine));
  LIMN_RETURN_IF_ERROR(CheckOutput(header.output()));
  ReadOutput(header.output(), &spec);
  return spec;
}

v1::SolveOptions::Method MethodToProto(SolveMethod method) {
  switch (method) {
    case SolveMethod::kChebyshev:
      return v1::SolveOptions::METHOD_CHEBYSHEV;
    case SolveMethod::kJacobi:
      return v1::SolveOptions::METHOD_JACOBI;
    case SolveMethod::kGaussSeidel:
      return v1::SolveOptions::METHOD_GAUSS_SEIDEL;
  }
  return v1::SolveOptions::METHOD_UNSPECIFIED;
}

v1::RepairReport RepairToProto(const RepairReport& report) {
  v1::RepairReport told;
  told.set_degenerate_faces_removed(report.degenerate_faces_removed);
  told.set_faces_mended(report.faces_mended);
  told.set_repeated_faces_removed(report.repeated_faces_removed);
  told.set_folded_faces_removed(report.folded_faces_removed);
  told.set_faces_reoriented(report.faces_reoriented);
  told.set_edges_cut(report.edges_cut);
  told.set_edges_split(report.edges_split);
  told.set_faces_split_off(report.faces_split_off);
  told.set_vertices_split(report.vertices_split);
  told.set_vertices_added(report.vertices_added);
  told.set_isolated_vertices_removed(report.isolated_vertices_removed);
  return told;
}

}  // namespace limn
