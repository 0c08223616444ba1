// SPDX-License-Identifier: MIT
#include "server/options_from_proto.h"

#include <cmath>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine/base/error.h"
#include "server/constraints_from_proto.h"

namespace limn {
namespace {

constexpr std::size_t kMaxRequestIdBytes = 128;

absl::Status Invalid(absl::string_view field, absl::string_view message, absl::string_view remedy) {
  return MakeError(absl::StrCat(field, ": ", message), {.reason = Reason::kInvalidOption,
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

absl::StatusOr<Scheme> SchemeFromProto(v1::Scheme scheme) {
  switch (scheme) {
    case v1::SCHEME_UNSPECIFIED:
    case v1::SCHEME_DOO_SABIN:
      return Scheme::kDooSabin;
    case v1::SCHEME_CATMULL_CLARK:
      return Scheme::kCatmullClark;
    case v1::SCHEME_LOOP:
      return Scheme::kLoop;
    default:
      return UnknownValue("scheme", scheme);
  }
}

absl::Status CheckEncoding(absl::string_view field, v1::MeshEncoding encoding) {
  if (v1::MeshEncoding_IsValid(encoding)) return absl::OkStatus();
  return UnknownValue(field, encoding);
}

absl::StatusOr<SolveMethod> MethodFromProto(v1::SolveOptions::Method method) {
  switch (method) {
    case v1::SolveOptions::METHOD_UNSPECIFIED:
      return SolveMethod::kAutomatic;
    case v1::SolveOptions::METHOD_CHEBYSHEV:
      return SolveMethod::kChebyshev;
    case v1::SolveOptions::METHOD_JACOBI:
      return SolveMethod::kJacobi;
    case v1::SolveOptions::METHOD_GAUSS_SEIDEL:
      return SolveMethod::kGaussSeidel;
    case v1::SolveOptions::METHOD_CONJUGATE_GRADIENT:
      return SolveMethod::kConjugateGradient;
    case v1::SolveOptions::METHOD_SERIES:
      return SolveMethod::kSeries;
    default:
      return UnknownValue("solve.method", method);
  }
}

absl::StatusOr<std::optional<FirstRule>> RuleFromProto(v1::SolveOptions::Rule rule) {
  switch (rule) {
    case v1::SolveOptions::RULE_UNSPECIFIED:
      return std::optional<FirstRule>();
    case v1::SolveOptions::RULE_MODIFIED:
      return FirstRule::kModified;
    case v1::SolveOptions::RULE_STANDARD:
      return FirstRule::kStandard;
    case v1::SolveOptions::RULE_BILINEAR_FIRST_STEP:
      return FirstRule::kBilinear;
    case v1::SolveOptions::RULE_FEATURE_VALUES:
      return FirstRule::kFeatures;
    default:
      return UnknownValue("solve.rule", rule);
  }
}

absl::StatusOr<SolveOptions> SolveFromProto(const v1::SolveOptions& solve) {
  SolveOptions options;
  LIMN_ASSIGN_OR_RETURN(options.method, MethodFromProto(solve.method()));
  if (solve.has_tolerance()) options.tolerance = solve.tolerance();
  if (solve.has_max_sweeps()) options.max_sweeps = solve.max_sweeps();
  LIMN_RETURN_IF_ERROR(ValidateSolveOptions(options));
  return options;
}

std::optional<BoundaryRule> BoundaryFromProto(v1::SurfaceOptions::Boundary boundary) {
  switch (boundary) {
    case v1::SurfaceOptions::BOUNDARY_NONE:
      return BoundaryRule::kNone;
    case v1::SurfaceOptions::BOUNDARY_EDGE_ONLY:
      return BoundaryRule::kEdgeOnly;
    case v1::SurfaceOptions::BOUNDARY_EDGE_AND_CORNER:
      return BoundaryRule::kEdgeAndCorner;
    default:
      return std::nullopt;
  }
}

absl::Status ReadSurface(const v1::SurfaceOptions& surface, InterpolateOptions* options) {
  if (surface.fineness_case() == v1::SurfaceOptions::kChordTolerance) {
    // Written so that NaN is refused.
    if (!(std::isfinite(surface.chord_tolerance()) && surface.chord_tolerance() > 0)) {
      return Invalid("surface.chord_tolerance",
                     absl::StrCat(surface.chord_tolerance(), " is not a finite number above 0"),
                     "It is a distance in model units");
    }
    options->chord_tolerance = surface.chord_tolerance();
    options->level = 0;
  }
  if (surface.fineness_case() == v1::SurfaceOptions::kLevel) {
    if (surface.level() > kMaxLevel) {
      return Invalid("surface.level", absl::StrCat(surface.level(), " is too many refinements"),
                     absl::StrCat("Use at most ", kMaxLevel));
    }
    options->level = surface.level();
  }
  if (!v1::SurfaceOptions::Boundary_IsValid(surface.boundary())) {
    return UnknownValue("surface.boundary", surface.boundary());
  }
  options->boundary = BoundaryFromProto(surface.boundary());
  return absl::OkStatus();
}

absl::Status CheckOutput(const v1::OutputOptions& output) {
  LIMN_RETURN_IF_ERROR(CheckEncoding("output.encoding", output.encoding()));
  constexpr std::uint32_t kLeastBits = wire::kMinQuantizationBits;
  constexpr std::uint32_t kMostBits = wire::kMaxQuantizationBits;
  const std::uint32_t bits = output.quantization_bits();
  if (bits != 0 && (bits < kLeastBits || bits > kMostBits)) {
    return Invalid("output.quantization_bits",
                   absl::StrCat(bits, " is not in [", kLeastBits, ", ", kMostBits, "]"),
                   "Leave it 0 for the default");
  }
  const std::uint32_t bytes = output.tile_bytes();
  if (bytes != 0 && (bytes < wire::kMinTileBytes || bytes > wire::kMaxTileBytes)) {
    return Invalid(
        "output.tile_bytes",
        absl::StrCat(bytes, " is not in [", wire::kMinTileBytes, ", ", wire::kMaxTileBytes, "]"),
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

// Draco meshes have vertices of faces only; holes leave others, which the numbering counts.
absl::Status CheckHolesTravel(const v1::OutputOptions& output, const JobSpec& spec) {
  const bool draco = output.encoding() == v1::MESH_ENCODING_DRACO ||
                     output.encoding() == v1::MESH_ENCODING_DRACO_QUANTIZED;
  const bool holes =
      !spec.engine.constraints.holes.empty() || spec.engine.boundary == BoundaryRule::kNone;
  if (!draco || !holes || !output.surface()) return absl::OkStatus();
  return Invalid("output.encoding", "a Draco surface cannot have the vertices inside holes",
                 "Use MESH_ENCODING_PACKED for surfaces with holes");
}

absl::Status CheckRepairWithFeatures(const v1::OutputOptions& output, const JobSpec& spec) {
  const std::optional<FeatureValues>& features = spec.engine.constraints.features;
  if (!output.repair() || !features.has_value() || !features->names_elements()) {
    return absl::OkStatus();
  }
  return Invalid("output.repair", "repair gives faces other numbers, which feature values name",
                 "Leave it off, and send a mesh that is repaired already");
}

void ReadOutput(const v1::OutputOptions& output, JobSpec* spec) {
  spec->send_control_mesh = output.control_mesh();
  spec->send_surface = output.surface();
  spec->send_normals = output.surface() && output.normals();
  spec->repair = output.repair();
  spec->engine.surface = true;
  // Prescribed normals are certified, whether normals are sent or not.
  spec->engine.normals = spec->send_normals || !spec->engine.constraints.normals.empty();
  if (!output.surface()) {
    spec->engine.level = 0;
    spec->engine.chord_tolerance.reset();
  }
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

absl::Status ReadFilter(const v1::FilterOptions& filter, JobSpec* spec) {
  spec->filter.emplace();
  spec->filter->gains.assign(filter.gains().begin(), filter.gains().end());
  spec->filter->rest = filter.rest();
  LIMN_RETURN_IF_ERROR(ValidateFilter(*spec->filter, spec->engine));
  // The filtered mesh is a control mesh.
  spec->engine.constraints.interpolate.emplace();
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<JobSpec> JobSpecFromProto(const v1::InterpolateHeader& header) {
  JobSpec spec;
  LIMN_RETURN_IF_ERROR(CheckRequestId(header.request_id()));
  spec.request_id = header.request_id();
  LIMN_ASSIGN_OR_RETURN(spec.engine.scheme, SchemeFromProto(header.scheme()));
  if (!header.has_mesh()) {
    return Invalid("mesh", "the header does not describe the mesh that follows",
                   "Set the counts and the encoding of the mesh");
  }
  LIMN_RETURN_IF_ERROR(CheckEncoding("mesh.encoding", header.mesh().encoding()));
  spec.mesh = header.mesh();
  if (spec.mesh.encoding() == v1::MESH_ENCODING_UNSPECIFIED) {
    spec.mesh.set_encoding(v1::MESH_ENCODING_PACKED);
  }
  LIMN_ASSIGN_OR_RETURN(spec.engine.constraints,
                        ConstraintsFromProto(header.constraints(), spec.mesh.vertex_count()));
  LIMN_ASSIGN_OR_RETURN(spec.engine.solve, SolveFromProto(header.solve()));
  LIMN_ASSIGN_OR_RETURN(spec.engine.rule, RuleFromProto(header.solve().rule()));
  spec.engine.fair = header.solve().fair();
  spec.engine.strict = header.solve().strict();
  LIMN_RETURN_IF_ERROR(ReadSurface(header.surface(), &spec.engine));
  LIMN_RETURN_IF_ERROR(CheckOutput(header.output()));
  ReadOutput(header.output(), &spec);
  LIMN_RETURN_IF_ERROR(CheckHolesTravel(header.output(), spec));
  LIMN_RETURN_IF_ERROR(CheckRepairWithFeatures(header.output(), spec));
  LIMN_RETURN_IF_ERROR(ValidateSchemeOptions(spec.engine));
  if (header.has_filter()) LIMN_RETURN_IF_ERROR(ReadFilter(header.filter(), &spec));
  return spec;
}

absl::StatusOr<JobSpec> EvaluateSpecFromProto(const v1::InterpolateHeader& header) {
  LIMN_ASSIGN_OR_RETURN(JobSpec spec, JobSpecFromProto(header));
  if (spec.send_surface || spec.send_control_mesh) {
    return Invalid(spec.send_surface ? "output.surface" : "output.control_mesh",
                   "Evaluate answers parameters only", "Leave it out; Interpolate sends it");
  }
  if (spec.mesh.encoding() == v1::MESH_ENCODING_DRACO_QUANTIZED) {
    return Invalid("mesh.encoding", "a quantised mesh has lost the order of its faces",
                   "Use a lossless encoding: parameters name faces by their numbers");
  }
  if (spec.repair) {
    return Invalid("output.repair", "repair gives faces other numbers, which parameters name",
                   "Leave it off, and send a mesh that is repaired already");
  }
  spec.engine.keep_patches = true;
  LIMN_RETURN_IF_ERROR(ValidateSchemeOptions(spec.engine));
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
    case SolveMethod::kSeries:
      return v1::SolveOptions::METHOD_SERIES;
    case SolveMethod::kConjugateGradient:
      return v1::SolveOptions::METHOD_CONJUGATE_GRADIENT;
    case SolveMethod::kAutomatic:
      break;
  }
  return v1::SolveOptions::METHOD_UNSPECIFIED;
}

v1::Scheme SchemeToProto(Scheme scheme) {
  switch (scheme) {
    case Scheme::kDooSabin:
      return v1::SCHEME_DOO_SABIN;
    case Scheme::kCatmullClark:
      return v1::SCHEME_CATMULL_CLARK;
    case Scheme::kLoop:
      return v1::SCHEME_LOOP;
  }
  return v1::SCHEME_UNSPECIFIED;
}

v1::SolveOptions::Rule RuleToProto(FirstRule rule) {
  switch (rule) {
    case FirstRule::kModified:
      return v1::SolveOptions::RULE_MODIFIED;
    case FirstRule::kStandard:
      return v1::SolveOptions::RULE_STANDARD;
    case FirstRule::kBilinear:
      return v1::SolveOptions::RULE_BILINEAR_FIRST_STEP;
    case FirstRule::kFeatures:
      return v1::SolveOptions::RULE_FEATURE_VALUES;
  }
  return v1::SolveOptions::RULE_UNSPECIFIED;
}

v1::FairnessReport FairnessToProto(const FairnessReport& report) {
  v1::FairnessReport told;
  told.set_energy_before(report.energy_before);
  told.set_energy_after(report.energy_after);
  told.set_shape_handles(report.shape_handles);
  told.set_smoothing(report.smoothing);
  return told;
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
