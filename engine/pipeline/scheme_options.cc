// SPDX-License-Identifier: MIT
// Which options and constraints belong to which scheme.
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/interpolate.h"

namespace limn {
namespace {

absl::Status Refuse(Reason reason, std::string field, std::string_view message,
                    std::string_view remedy) {
  std::string text = absl::StrCat(field, ": ", std::string(message));
  return MakeError(text,
                   {.reason = reason, .field = std::move(field), .remedy = std::string(remedy)});
}

absl::Status OnlyForOthers(std::string field, std::string_view what) {
  return Refuse(Reason::kInvalidOption, std::move(field),
                absl::StrCat(std::string(what), " belong to Catmull-Clark and Loop surfaces"),
                "Leave them out or choose another scheme");
}

absl::Status CheckDooSabin(const InterpolateOptions& options) {
  const Constraints& constraints = options.constraints;
  if (!constraints.creases.empty()) return OnlyForOthers("constraints.creases", "creases");
  if (!constraints.corners.empty()) return OnlyForOthers("constraints.corners", "sharp corners");
  if (!constraints.holes.empty()) return OnlyForOthers("constraints.holes", "holes");
  if (!constraints.surface_points.empty()) {
    return OnlyForOthers("constraints.surface_points", "constraints anywhere on the surface");
  }
  if (options.boundary.has_value()) return OnlyForOthers("surface.boundary", "boundary rules");
  if (options.rule == FirstRule::kBilinear) {
    return Refuse(Reason::kInvalidOption, "solve.rule",
                  "the bilinear first step belongs to Catmull-Clark surfaces",
                  "Choose the modified or the standard rule");
  }
  if (options.rule == FirstRule::kFeatures) {
    return Refuse(Reason::kInvalidOption, "solve.rule", "feature values are no rule to be named",
                  "Give constraints.features and no rule");
  }
  if (constraints.features.has_value() && options.rule.has_value()) {
    return Refuse(Reason::kInvalidOption, "solve.rule",
                  "feature values are the first refinement themselves",
                  "Leave the rule out, or constraints.features");
  }
  if (constraints.features.has_value() && options.fair) {
    return Refuse(Reason::kInvalidOption, "solve.fair",
                  "fairing would undo what feature values ask for",
                  "Leave it out, or constraints.features");
  }
  return absl::OkStatus();
}

absl::Status NoChordBound() {
  return Refuse(Reason::kUnimplemented, "surface.chord_tolerance",
                "chord tolerances of Catmull-Clark and Loop surfaces are not implemented yet",
                "Choose a level");
}

absl::Status CheckPrimal(const InterpolateOptions& options) {
  const Constraints& constraints = options.constraints;
  if (constraints.features.has_value()) {
    return Refuse(Reason::kInvalidOption, "constraints.features",
                  "feature values belong to Doo-Sabin surfaces",
                  "Leave them out or choose Doo-Sabin");
  }
  if (options.rule == FirstRule::kFeatures) {
    return Refuse(Reason::kInvalidOption, "solve.rule", "feature values belong to Doo-Sabin",
                  "Choose the standard rule or none");
  }
  if (!constraints.shape_handles.empty()) {
    return Refuse(Reason::kInvalidOption, "constraints.shape_handles",
                  "shape handles belong to Doo-Sabin surfaces",
                  "Leave them out or choose Doo-Sabin");
  }
  if (options.fair) {
    return Refuse(Reason::kInvalidOption, "solve.fair", "fairing belongs to Doo-Sabin surfaces",
                  "Leave it out or choose Doo-Sabin");
  }
  if (options.chord_tolerance.has_value()) return NoChordBound();
  if (options.rule == FirstRule::kModified) {
    return Refuse(Reason::kInvalidOption, "solve.rule", "the modified rule belongs to Doo-Sabin",
                  "Choose the standard rule or none");
  }
  if (options.rule == FirstRule::kBilinear && options.scheme == Scheme::kLoop) {
    return Refuse(Reason::kInvalidOption, "solve.rule",
                  "the bilinear first step belongs to Catmull-Clark",
                  "Choose the standard rule or none");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateSchemeOptions(const InterpolateOptions& options) {
  return options.scheme == Scheme::kDooSabin ? CheckDooSabin(options) : CheckPrimal(options);
}

}  // namespace limn
