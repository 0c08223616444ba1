// SPDX-License-Identifier: MIT
// The files that `limn interpolate` writes; those of `limn evaluate` are checked here too.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/staged_files.h"
#include "client/client.h"

namespace limn::cli {

struct OutputPaths {
  // One surface in as many formats as wanted.
  std::vector<std::string> surfaces;
  // Empty: not wanted.
  std::string control_mesh;
  std::string report;
  // Samples of an evaluation; see client/cli/samples_file.h.
  std::string samples;
};

// The same for any two ways to write the name of one file, whether it exists or not.
[[nodiscard]] std::filesystem::path FileIdentity(const std::string& path);

// Whether all of them can be written, before any work is done. inputs: which must not be among
// them; empty names are none. Errors: those of CheckWritable; INVALID_OPTION for a file that is
// named twice.
[[nodiscard]] absl::Status CheckOutputs(const OutputPaths& paths,
                                        const std::vector<std::string>& inputs);

// Writes all of them, for files->Commit to put in their places. Errors: those of the writers.
[[nodiscard]] absl::Status WriteOutputs(const OutputPaths& paths, const JobResult& result,
                                        StagedFiles* files);

// Writes the report alone; nothing for an empty path.
[[nodiscard]] absl::Status WriteReport(const std::string& path, const v1::Summary& summary,
                                       StagedFiles* files);

}  // namespace limn::cli
