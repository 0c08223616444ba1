// SPDX-License-Identifier: MIT
// The flags that say what a job is, and the header they make.
#include "client/cli/job_options.h"

#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/Error.hpp>
#include <CLI/Validators.hpp>

#include "absl/strings/str_cat.h"
#include "client/cli/job_checks.h"
#include "engine/base/context.h"
#include "engine/solve/solve.h"
#include "limn/v1/mesh.pb.h"
#include "proto/wire/quantization_grid.h"

namespace limn::cli {
namespace {

using SolveMethod = v1::SolveOptions::Method;
using FirstRule = v1::SolveOptions::Rule;
using Boundary = v1::SurfaceOptions::Boundary;

template <class T, std::size_t kCount>
using Names = std::array<std::pair<std::string_view, T>, kCount>;

constexpr Names<v1::Scheme, 3> kSchemes = {{
    {"doo-sabin", v1::SCHEME_DOO_SABIN},
    {"catmull-clark", v1::SCHEME_CATMULL_CLARK},
    {"loop", v1::SCHEME_LOOP},
}};

constexpr Names<SolveMethod, 5> kSolvers = {{
    {"chebyshev", v1::SolveOptions::METHOD_CHEBYSHEV},
    {"jacobi", v1::SolveOptions::METHOD_JACOBI},
    {"gauss-seidel", v1::SolveOptions::METHOD_GAUSS_SEIDEL},
    {"conjugate-gradient", v1::SolveOptions::METHOD_CONJUGATE_GRADIENT},
    {"series", v1::SolveOptions::METHOD_SERIES},
}};

constexpr Names<FirstRule, 3> kRules = {{
    {"modified", v1::SolveOptions::RULE_MODIFIED},
    {"standard", v1::SolveOptions::RULE_STANDARD},
    {"bilinear", v1::SolveOptions::RULE_BILINEAR_FIRST_STEP},
}};

constexpr Names<Boundary, 3> kBoundaries = {{
    {"none", v1::SurfaceOptions::BOUNDARY_NONE},
    {"edge-only", v1::SurfaceOptions::BOUNDARY_EDGE_ONLY},
    {"edge-and-corner", v1::SurfaceOptions::BOUNDARY_EDGE_AND_CORNER},
}};

// How results travel.
constexpr Names<v1::MeshEncoding, 3> kEncodings = {{
    {"packed", v1::MESH_ENCODING_PACKED},
    {"draco", v1::MESH_ENCODING_DRACO},
    {"draco-quantized", v1::MESH_ENCODING_DRACO_QUANTIZED},
}};

template <class T, std::size_t kCount>
CLI::IsMember OneOf(const Names<T, kCount>& names) {
  std::vector<std::string> words;
  for (const auto& [word, value] : names) words.emplace_back(word);
  return CLI::IsMember(std::move(words));
}

template <class T, std::size_t kCount>
T ValueOf(const Names<T, kCount>& names, std::string_view name) {
  for (const auto& [word, value] : names) {
    if (word == name) return value;
  }
  return T{};
}

// Empty if the text is a number in [0, 1). Written out: CLI::Range lets NaN pass.
std::string CheckTolerance(const std::string& text) {
  double value = 0;
  if (!CLI::detail::lexical_cast(text, value) || !(value >= 0 && value < 1)) {
    return "must be a number from 0 up to, but not including, 1; got '" + text + "'";
  }
  return {};
}

// Empty if the text is a number above 0 and finite.
std::string CheckDistance(const std::string& text) {
  double value = 0;
  if (!CLI::detail::lexical_cast(text, value) || !(value > 0 && std::isfinite(value))) {
    return "must be a number above 0; got '" + text + "'";
  }
  return {};
}

// Empty if the text is a finite number.
std::string CheckFinite(const std::string& text) {
  double value = 0;
  if (!CLI::detail::lexical_cast(text, value) || !std::isfinite(value)) {
    return "must be a number; got '" + text + "'";
  }
  return {};
}

void CheckAtTheEnd(CLI::App& app, const JobOptions* options) {
  app.parse_complete_callback([options] {
    const absl::Status status = CheckTogether(*options);
    if (!status.ok()) throw CLI::ValidationError(std::string(status.message()));
  });
}

void AddSchemeFlags(CLI::App& app, JobOptions* options) {
  app.add_option("--scheme", options->scheme, "Subdivision scheme; loop is for triangles")
      ->check(OneOf(kSchemes))
      ->capture_default_str();
  app.add_option("--boundary", options->boundary,
                 "What becomes of the boundary under catmull-clark and loop, as in OpenSubdiv "
                 "[edge-and-corner]")
      ->check(OneOf(kBoundaries));
}

}  // namespace

void AddSolveFlags(CLI::App& app, JobOptions* options) {
  AddSchemeFlags(app, options);
  app.add_option("--solver", options->solver,
                 "Iteration that finds the control mesh [chebyshev, or conjugate-gradient where no "
                 "bound of the spectrum is known that serves]")
      ->check(OneOf(kSolvers));
  app.add_option("--rule", options->rule,
                 "First refinement that the equations are set up with: Zheng and Cai's modified "
                 "one (doo-sabin's default), the scheme's own (for doo-sabin Nasri's method), or a "
                 "bilinear one (catmull-clark takes a share of it where its own equations are "
                 "singular or nearly so)")
      ->check(OneOf(kRules));
  app.add_flag("--strict", options->strict, "Refuse such meshes instead");
  app.add_option("--tolerance", options->tolerance,
                 "Stop when no vertex moves further in a sweep than this part of the bounding "
                 "box's diagonal; 0 runs --max-sweeps [1e-12]")
      ->check(CLI::Validator(CheckTolerance, "", "tolerance"))
      ->type_name("EPS");
  app.add_option("--max-sweeps", options->max_sweeps,
                 absl::StrCat("Sweeps at the most, 0 to ", kMaxSweeps, " [100]"))
      ->check(CLI::Range(0U, kMaxSweeps))
      ->type_name("N");
  app.add_flag("--fair", options->fair,
               "Cure overshoot where edge lengths differ, when that lowers the bending energy");
  CheckAtTheEnd(app, options);
}

void AddFilterFlags(CLI::App& app, JobOptions* options) {
  AddSchemeFlags(app, options);
  app.add_option("--gains", options->gains,
                 "Gain of each term of the series, from smooth to rough: '1' smooths, '1,0.5' less "
                 "so, '0' with --rest 1 leaves the details")
      ->delimiter(',')
      ->required()
      ->check(CLI::Validator(CheckFinite, "", "gain"))
      ->type_name("G[,G...]");
  app.add_option("--rest", options->rest,
                 "Gain of all terms after these: 0 leaves them out, above 1 sharpens")
      ->check(CLI::Validator(CheckFinite, "", "gain"))
      ->capture_default_str()
      ->type_name("G");
}

void AddTessellationFlags(CLI::App& app, JobOptions* options) {
  CLI::Option* const level =
      app.add_option("--level", options->level,
                     absl::StrCat("Refinements of the tessellation, 0 to ", kMaxLevel))
          ->check(CLI::Range(0U, kMaxLevel))
          ->capture_default_str()
          ->type_name("K");
  app.add_option("--chord-tolerance", options->chord_tolerance,
                 "Instead of a level: the smallest one that is guaranteed to be this near to the "
                 "limit surface, in model units (doo-sabin)")
      ->check(CLI::Validator(CheckDistance, "", "distance"))
      ->excludes(level)
      ->type_name("T");
  app.add_option("--encoding", options->encoding,
                 "How meshes travel; draco-quantized is lossy: it moves points and reorders faces")
      ->check(OneOf(kEncodings))
      ->capture_default_str();
  constexpr std::uint32_t kLeastBits = wire::kMinQuantizationBits;
  constexpr std::uint32_t kMostBits = wire::kMaxQuantizationBits;
  app.add_option("--quantization-bits", options->quantization_bits,
                 absl::StrCat("Bits per coordinate of draco-quantized, ", kLeastBits, " to ",
                              kMostBits, " [16]"))
      ->check(CLI::Range(kLeastBits, kMostBits))
      ->type_name("N");
  app.add_flag("--repair", options->repair,
               "Mend a mesh that would be refused, and say what was changed: degenerate, repeated "
               "and turned faces, edges of more than two faces, vertices of several fans or of no "
               "face");
  CheckAtTheEnd(app, options);
}

v1::InterpolateHeader MakeJobHeader(const JobOptions& options, const WantedOutputs& wanted) {
  v1::InterpolateHeader header;
  header.set_scheme(ValueOf(kSchemes, options.scheme));
  if (options.solver) header.mutable_solve()->set_method(ValueOf(kSolvers, *options.solver));
  if (options.rule) header.mutable_solve()->set_rule(ValueOf(kRules, *options.rule));
  if (options.tolerance) header.mutable_solve()->set_tolerance(*options.tolerance);
  if (options.max_sweeps) header.mutable_solve()->set_max_sweeps(*options.max_sweeps);
  header.mutable_solve()->set_strict(options.strict);
  if (options.chord_tolerance) {
    header.mutable_surface()->set_chord_tolerance(*options.chord_tolerance);
  } else {
    header.mutable_surface()->set_level(options.level);
  }
  if (options.boundary) {
    header.mutable_surface()->set_boundary(ValueOf(kBoundaries, *options.boundary));
  }
  if (!options.gains.empty()) {
    v1::FilterOptions& filter = *header.mutable_filter();
    filter.mutable_gains()->Assign(options.gains.begin(), options.gains.end());
    filter.set_rest(options.rest);
  }

  const v1::MeshEncoding encoding = ValueOf(kEncodings, options.encoding);
  // The given points are never quantised: the surface has to pass through them.
  header.mutable_mesh()->set_encoding(
      encoding == v1::MESH_ENCODING_DRACO_QUANTIZED ? v1::MESH_ENCODING_DRACO : encoding);
  v1::OutputOptions& output = *header.mutable_output();
  output.set_encoding(encoding);
  if (options.quantization_bits) output.set_quantization_bits(*options.quantization_bits);
  output.set_surface(wanted.surface);
  output.set_normals(wanted.surface);
  output.set_control_mesh(wanted.control_mesh);
  output.set_repair(options.repair);
  header.mutable_solve()->set_fair(options.fair);
  return header;
}

}  // namespace limn::cli
