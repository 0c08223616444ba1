// SPDX-License-Identifier: MIT
// Output files that appear all together or not at all.
#include "client/cli/staged_files.h"

#include <unistd.h>

#include <filesystem>
#include <system_error>

namespace limn::cli {
namespace {

namespace fs = std::filesystem;

// Where a file written to `path` ends up.
fs::path Followed(const std::string& path) {
  std::error_code error;
  const fs::path canonical = fs::canonical(path, error);
  return error ? fs::path(path) : canonical;
}

}  // namespace

StagedFiles::~StagedFiles() {
  std::error_code ignored;
  for (const File& file : files_) fs::remove(file.temporary, ignored);
}

std::string StagedFiles::Stage(const std::string& path) {
  const fs::path target = Followed(path);
  const std::string name = ".limn-" + std::to_string(getpid()) + "-" +
                           std::to_string(files_.size()) + target.extension().string();
  files_.push_back({(target.parent_path() / name).string(), target.string()});
  return files_.back().temporary;
}

absl::Status StagedFiles::Commit() {
  std::error_code error;
  std::size_t moved = 0;
  for (; moved < files_.size(); ++moved) {
    const File& file = files_[moved];
    const fs::file_status there = fs::status(file.target, error);
    if (fs::exists(there)) fs::permissions(file.temporary, there.permissions(), error);
    fs::rename(file.temporary, file.target, error);
    if (error) break;
  }
  if (moved == files_.size()) {
    files_.clear();
    return absl::OkStatus();
  }
  std::error_code ignored;
  for (std::size_t i = 0; i < moved; ++i) fs::remove(files_[i].target, ignored);
  return absl::UnknownError("'" + files_[moved].target + "' cannot be written: " + error.message());
}

}  // namespace limn::cli
