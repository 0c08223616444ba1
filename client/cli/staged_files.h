// SPDX-License-Identifier: MIT
// Output files that appear all together or not at all.
#pragma once

#include <string>
#include <vector>

#include "absl/status/status.h"

namespace limn::cli {

// Files are written beside their places under names of their own, and moved there at the end.
// Whatever is not committed is removed. Not thread-safe.
class StagedFiles {
 public:
  StagedFiles() = default;
  ~StagedFiles();
  StagedFiles(const StagedFiles&) = delete;
  StagedFiles& operator=(const StagedFiles&) = delete;

  // Where to write the file that is to stand at `path`: in the same folder, with the same
  // extension. A symbolic link is followed, so that it stays one.
  std::string Stage(const std::string& path);

  // Moves every file to its place. After an error none of them stands there.
  [[nodiscard]] absl::Status Commit();

 private:
  struct File {
    std::string temporary;
    std::string target;
  };
  std::vector<File> files_;
};

}  // namespace limn::cli
