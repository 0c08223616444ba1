// SPDX-License-Identifier: MIT
// Output files that appear all together or not at all.
#include "client/cli/staged_files.h"

#include <utility>

#include "engine/base/error.h"

namespace limn::cli {

absl::StatusOr<io::OutputFile*> StagedFiles::Create(const std::string& path) {
  LIMN_ASSIGN_OR_RETURN(std::unique_ptr<io::OutputFile> file, io::OutputFile::Create(path, stop_));
  files_.push_back(std::move(file));
  return files_.back().get();
}

absl::Status StagedFiles::Commit() {
  for (const auto& file : files_) LIMN_RETURN_IF_ERROR(file->Close());
  for (std::size_t i = 0; i < files_.size(); ++i) {
    absl::Status status = files_[i]->Place();
    if (status.ok()) continue;
    // The last first: two names may be links to one file.
    while (i-- > 0) files_[i]->Undo();
    return status;
  }
  files_.clear();
  return absl::OkStatus();
}

}  // namespace limn::cli
