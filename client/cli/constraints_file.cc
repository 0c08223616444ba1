// SPDX-License-Identifier: MIT
// Constraints in a file: the JSON mapping of limn.v1.Constraints.
#include "client/cli/constraints_file.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/cli/message_file.h"
#include "engine/base/error.h"

namespace limn::cli {

void AddConstraintsFlag(CLI::App& app, std::string* path) {
  app.add_option("--constraints", *path,
                 "What the surface meets, as JSON of limn.v1.Constraints: which vertices to "
                 "interpolate [all], and for doo-sabin normals, shapeHandles and features, for "
                 "catmull-clark and loop normals, surfacePoints, creases, corners and holes")
      ->type_name("FILE.json");
}

absl::StatusOr<v1::Constraints> ParseConstraints(const std::string& json, const std::string& path) {
  v1::Constraints constraints;
  LIMN_RETURN_IF_ERROR(ParseMessage(
      json, {.path = path, .field = "constraints", .prefix = "constraints."}, &constraints));
  return constraints;
}

absl::StatusOr<v1::Constraints> ReadConstraintsFile(const std::string& path) {
  LIMN_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path));
  return ParseConstraints(text, path);
}

absl::StatusOr<v1::FeatureValues> ReadFeaturesFile(const std::string& path) {
  LIMN_ASSIGN_OR_RETURN(const std::string text, ReadTextFile(path));
  v1::FeatureValues features;
  LIMN_RETURN_IF_ERROR(ParseMessage(
      text, {.path = path, .field = "constraints.features", .prefix = "constraints.features."},
      &features));
  return features;
}

absl::Status NameConstraintsFile(const absl::Status& status, const std::string& path) {
  const auto detail = GetErrorDetail(status);
  if (path.empty() || !detail.has_value()) return status;
  const bool too_large = status.code() == absl::StatusCode::kResourceExhausted &&
                         absl::StrContains(status.message(), "message larger than max");
  if (!too_large && !detail->field.starts_with("constraints")) return status;
  return Surrounded(
      absl::StrCat(path, ": "), status,
      too_large ? ". Use fewer constraints, or raise the server's --max-message-bytes" : "");
}

}  // namespace limn::cli
