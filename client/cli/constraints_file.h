// SPDX-License-Identifier: MIT
// Constraints in a file: the JSON mapping of limn.v1.Constraints, such as
//   {"interpolate": {"vertices": [0, 5]},
//    "normals": [{"vertex": 5, "normal": {"x": 0, "y": 0, "z": 1}}],
//    "shapeHandles": [{"vertex": 12, "value": 0.4}]}
#pragma once

#include <string>

#include <CLI/App.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "limn/v1/constraints.pb.h"

namespace limn::cli {

// Adds --constraints FILE.json.
void AddConstraintsFlag(CLI::App& app, std::string* path);

// The constraints that a text holds. Whether they make sense for a mesh is for the server to say.
// Errors: MALFORMED_FILE, whose message begins with the file's name and, where there is one, the
// field's path: what is no JSON, unknown fields, values of the wrong type or out of their type's
// range.
[[nodiscard]] absl::StatusOr<v1::Constraints> ParseConstraints(const std::string& json,
                                                               const std::string& path);

// The constraints in a file. Errors: as ParseConstraints; those of the system, naming the file;
// MALFORMED_FILE for files above 256 MiB.
[[nodiscard]] absl::StatusOr<v1::Constraints> ReadConstraintsFile(const std::string& path);

// The same for feature values alone, limn.v1.FeatureValues, such as
//   {"defaultEdge": 0.3, "faces": [{"face": 4, "kind": "FACE_KIND_PLANE"}],
//    "edges": [{"from": 0, "to": 1, "face": 2, "value": 0}], "vertices": [{"vertex": 7}]}
[[nodiscard]] absl::StatusOr<v1::FeatureValues> ReadFeaturesFile(const std::string& path);

// A job's error, with the file's name before it where it speaks of the constraints that came from
// there: a refusal by their field, or that they do not fit a message. path: empty for none.
[[nodiscard]] absl::Status NameConstraintsFile(const absl::Status& status, const std::string& path);

}  // namespace limn::cli
