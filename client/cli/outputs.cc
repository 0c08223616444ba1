// SPDX-License-Identifier: MIT
// The files that `limn interpolate` writes.
#include "client/cli/outputs.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "client/cli/report.h"
#include "client/io/mesh_writer.h"
#include "client/io/output_file.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

namespace fs = std::filesystem;

absl::Status CheckDistinct(const OutputPaths& paths, const std::vector<std::string>& inputs) {
  std::vector<std::string> all = paths.surfaces;
  if (!paths.control_mesh.empty()) all.push_back(paths.control_mesh);
  if (!paths.report.empty()) all.push_back(paths.report);
  if (!paths.samples.empty()) all.push_back(paths.samples);
  std::vector<fs::path> seen;
  for (const std::string& input : inputs) {
    if (!input.empty()) seen.push_back(FileIdentity(input));
  }
  const std::size_t input_count = seen.size();
  for (const std::string& path : all) {
    fs::path identity = FileIdentity(path);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (seen[i] != identity) continue;
      const std::string what = i < input_count ? " is an input" : " is named for two outputs";
      return MakeError("'" + path + "'" + what, {.reason = Reason::kInvalidOption,
                                                 .field = "output",
                                                 .remedy = "Give every file its own name"});
    }
    seen.push_back(std::move(identity));
  }
  return absl::OkStatus();
}

}  // namespace

fs::path FileIdentity(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  const fs::path canonical = fs::weakly_canonical(absolute, error);
  return error ? fs::path(path) : canonical;
}

absl::Status CheckOutputs(const OutputPaths& paths, const std::vector<std::string>& inputs) {
  LIMN_RETURN_IF_ERROR(CheckDistinct(paths, inputs));
  for (const std::string& path : paths.surfaces) {
    LIMN_RETURN_IF_ERROR(CheckWritable(path, OutputKind::kSurface));
  }
  if (!paths.control_mesh.empty()) {
    LIMN_RETURN_IF_ERROR(CheckWritable(paths.control_mesh, OutputKind::kMesh));
  }
  for (const std::string& path : {paths.report, paths.samples}) {
    if (!path.empty()) LIMN_RETURN_IF_ERROR(io::OutputFile::Create(path).status());
  }
  return absl::OkStatus();
}

absl::Status WriteOutputs(const OutputPaths& paths, const JobResult& result, StagedFiles* files) {
  for (const std::string& path : paths.surfaces) {
    LIMN_ASSIGN_OR_RETURN(io::OutputFile* const file, files->Create(path));
    LIMN_RETURN_IF_ERROR(WriteSurfaceTo(path, result.surface, file));
  }
  if (!paths.control_mesh.empty()) {
    LIMN_ASSIGN_OR_RETURN(io::OutputFile* const file, files->Create(paths.control_mesh));
    LIMN_RETURN_IF_ERROR(WriteMeshTo(paths.control_mesh, result.control_mesh, file));
  }
  return WriteReport(paths.report, result.summary, files);
}

absl::Status WriteReport(const std::string& path, const v1::Summary& summary, StagedFiles* files) {
  if (path.empty()) return absl::OkStatus();
  LIMN_ASSIGN_OR_RETURN(const std::string json, SummaryJson(summary));
  LIMN_ASSIGN_OR_RETURN(io::OutputFile* const file, files->Create(path));
  file->Append(json);
  return absl::OkStatus();
}

}  // namespace limn::cli
