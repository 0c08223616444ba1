// SPDX-License-Identifier: MIT
#include "client/cli/batch_outputs.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/io/mesh_writer.h"
#include "client/io/output_file.h"
#include "engine/base/error.h"

namespace limn::cli {
namespace {

namespace fs = std::filesystem;

absl::Status Clash(const std::string& path, std::string_view what) {
  return MakeError(absl::StrCat("'", path, "' ", std::string(what)),
                   {.reason = Reason::kInvalidOption,
                    .field = "output",
                    .remedy = "Give every file its own name, or -o another folder"});
}

// glTF has no polygons.
std::string MeshFormat(const std::vector<std::string>& formats) {
  const auto found = std::find_if(formats.begin(), formats.end(),
                                  [](const std::string& format) { return format != "glb"; });
  return found == formats.end() ? "ply" : *found;
}

absl::Status MakeFolder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && fs::is_directory(folder, error)) return absl::OkStatus();
  return absl::ErrnoToStatus(error ? error.value() : ENOTDIR,
                             absl::StrCat("cannot make the folder ", folder));
}

}  // namespace

OutputPaths OutputsOf(const BatchEntry& entry, const BatchOutputs& outputs) {
  const std::string base = (fs::path(outputs.folder) / entry.output).string();
  OutputPaths paths;
  for (const std::string& format : outputs.formats) {
    paths.surfaces.push_back(absl::StrCat(base, ".", format));
  }
  if (outputs.control_mesh) {
    paths.control_mesh = absl::StrCat(base, ".control.", MeshFormat(outputs.formats));
  }
  if (outputs.job_reports) paths.report = base + ".json";
  return paths;
}

std::vector<std::string> FilesOf(const OutputPaths& paths) {
  std::vector<std::string> files = paths.surfaces;
  if (!paths.control_mesh.empty()) files.push_back(paths.control_mesh);
  if (!paths.report.empty()) files.push_back(paths.report);
  return files;
}

absl::Status CheckBatchOutputs(const std::vector<BatchEntry>& entries, const BatchOutputs& outputs,
                               const std::vector<std::string>& others) {
  LIMN_RETURN_IF_ERROR(MakeFolder(outputs.folder));
  std::set<fs::path> inputs;
  for (const std::string& path : others) {
    if (!path.empty()) inputs.insert(FileIdentity(path));
  }
  for (const BatchEntry& entry : entries) {
    inputs.insert(FileIdentity(entry.input));
    if (!entry.constraints.empty()) inputs.insert(FileIdentity(entry.constraints));
  }
  std::set<fs::path> seen;
  const auto check = [&](const std::string& path) {
    fs::path identity = FileIdentity(path);
    if (inputs.contains(identity)) return Clash(path, "is an input");
    if (seen.insert(std::move(identity)).second) return absl::OkStatus();
    return Clash(path, "would be written by two jobs");
  };
  for (const BatchEntry& entry : entries) {
    for (const std::string& file : FilesOf(OutputsOf(entry, outputs))) {
      LIMN_RETURN_IF_ERROR(check(file));
    }
  }
  if (outputs.report.empty()) return absl::OkStatus();
  LIMN_RETURN_IF_ERROR(check(outputs.report));
  return io::OutputFile::Create(outputs.report).status();
}

}  // namespace limn::cli
