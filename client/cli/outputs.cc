// SPDX-License-Identifier: MIT
// The files that `limn interpolate` writes.
#include "client/cli/outputs.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/strings/str_replace.h"
#include "client/cli/report.h"
#include "client/cli/staged_files.h"
#include "client/io/mesh_writer.h"
#include "client/io/output_file.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

namespace fs = std::filesystem;

// The same for any two ways to write the name of one file, whether it exists or not.
fs::path Identity(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  const fs::path canonical = fs::weakly_canonical(absolute, error);
  return error ? fs::path(path) : canonical;
}

absl::Status CheckDistinct(const OutputPaths& paths, const std::vector<std::string>& inputs) {
  std::vector<std::string> all = paths.surfaces;
  if (!paths.control_mesh.empty()) all.push_back(paths.control_mesh);
  if (!paths.report.empty()) all.push_back(paths.report);
  std::vector<fs::path> seen;
  for (const std::string& input : inputs) {
    if (!input.empty()) seen.push_back(Identity(input));
  }
  const std::size_t input_count = seen.size();
  for (const std::string& path : all) {
    fs::path identity = Identity(path);
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

absl::Status WriteText(const std::string& path, const std::string& text) {
  LIMN_ASSIGN_OR_RETURN(const std::unique_ptr<io::OutputFile> file, io::OutputFile::Create(path));
  file->Append(text);
  return file->Commit();
}

using WriteFunction = std::function<absl::Status(const std::string& path)>;

// Writes to the staged name of `path`, but speaks of `path` when that fails.
absl::Status WriteStaged(StagedFiles* files, const std::string& path, const WriteFunction& write) {
  const std::string temporary = files->Stage(path);
  absl::Status status = write(temporary);
  if (status.ok()) return status;
  return {status.code(), absl::StrReplaceAll(status.message(), {{temporary, path}})};
}

}  // namespace

absl::Status CheckOutputs(const OutputPaths& paths, const std::vector<std::string>& inputs) {
  LIMN_RETURN_IF_ERROR(CheckDistinct(paths, inputs));
  for (const std::string& path : paths.surfaces) {
    LIMN_RETURN_IF_ERROR(CheckWritable(path, OutputKind::kSurface));
  }
  if (!paths.control_mesh.empty()) {
    LIMN_RETURN_IF_ERROR(CheckWritable(paths.control_mesh, OutputKind::kMesh));
  }
  if (!paths.report.empty()) return io::OutputFile::Create(paths.report).status();
  return absl::OkStatus();
}

absl::Status WriteOutputs(const OutputPaths& paths, const JobResult& result) {
  StagedFiles files;
  for (const std::string& path : paths.surfaces) {
    LIMN_RETURN_IF_ERROR(WriteStaged(&files, path, [&](const std::string& temporary) {
      return WriteSurfaceFile(temporary, result.surface);
    }));
  }
  if (!paths.control_mesh.empty()) {
    LIMN_RETURN_IF_ERROR(WriteStaged(&files, paths.control_mesh, [&](const std::string& temporary) {
      return WriteMeshFile(temporary, result.control_mesh);
    }));
  }
  if (!paths.report.empty()) {
    LIMN_ASSIGN_OR_RETURN(const std::string json, SummaryJson(result.summary));
    LIMN_RETURN_IF_ERROR(WriteStaged(&files, paths.report, [&](const std::string& temporary) {
      return WriteText(temporary, json);
    }));
  }
  return files.Commit();
}

}  // namespace limn::cli
