// SPDX-License-Identifier: MIT
// The jobs of a batch: a folder of meshes, or a file with a JSON object per line, such as
//   {"input": "meshes/a.obj"}
//   {"input": "b.ply", "id": "fine b", "output": "b-fine", "level": 4, "constraints": "c.json"}
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/job_options.h"

namespace limn::cli {

struct BatchEntry {
  // Unique in the batch.
  std::string id;
  std::string input;
  // Name of its files, without folder and ending; unique in the batch.
  std::string output;
  // Empty for none.
  std::string constraints;
  JobOptions options;
};

// The jobs in their order: those of a folder are its files with an ending of a mesh, sorted by
// name. Members of a line are input, and if wanted id [the input's name without folder and ending],
// output [the id], constraints, scheme, level or chordTolerance, and repair; for the others
// `defaults` holds. Paths are relative to the manifest's folder. Empty lines are left out.
//
// Errors, which name the line: MALFORMED_FILE for what is no such object; INVALID_OPTION for values
// that make no sense, and ids and outputs that two jobs have; EMPTY_MESH when there are no jobs;
// those of the system. Meshes and constraints are not looked at.
[[nodiscard]] absl::StatusOr<std::vector<BatchEntry>> ReadBatchEntries(const std::string& path,
                                                                       const BatchEntry& defaults);

}  // namespace limn::cli
