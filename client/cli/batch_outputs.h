// SPDX-License-Identifier: MIT
// Where the files of a batch's jobs go.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/batch_manifest.h"
#include "client/cli/outputs.h"

namespace limn::cli {

struct BatchOutputs {
  std::string folder;
  // Endings of surfaces, without the dot. One at least.
  std::vector<std::string> formats;
  bool control_mesh = false;
  // A report for each job.
  bool job_reports = false;
  // That of the whole batch; empty for none.
  std::string report;
};

// FOLDER/OUTPUT.FORMAT for each format, OUTPUT.control.FORMAT in the first format that a mesh can
// have, OUTPUT.json.
[[nodiscard]] OutputPaths OutputsOf(const BatchEntry& entry, const BatchOutputs& outputs);
// All of them.
[[nodiscard]] std::vector<std::string> FilesOf(const OutputPaths& paths);

// Before any work: makes the folder, and looks whether any output would overwrite an input,
// `others` or another output. Errors: INVALID_OPTION; those of the system.
[[nodiscard]] absl::Status CheckBatchOutputs(const std::vector<BatchEntry>& entries,
                                             const BatchOutputs& outputs,
                                             const std::vector<std::string>& others);

}  // namespace limn::cli
