// SPDX-License-Identifier: MIT
// Output files that appear all together or not at all.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/io/output_file.h"

namespace limn::cli {

// Files are written beside their places and moved there at the end. Whatever is not committed is
// removed; a file that stood there before is untouched until then, and stands there again when
// another one cannot be put in its place. Not thread-safe.
class StagedFiles {
 public:
  // stop: as in io::OutputFile::Create.
  explicit StagedFiles(std::function<bool()> stop = {}) : stop_(std::move(stop)) {}

  // The file that is to stand at `path`; it belongs to this object. A symbolic link is followed, so
  // that it stays one. Errors: as io::OutputFile::Create.
  [[nodiscard]] absl::StatusOr<io::OutputFile*> Create(const std::string& path);

  // Moves every file to its place. After an error everything stands there as before.
  [[nodiscard]] absl::Status Commit();

 private:
  std::function<bool()> stop_;
  std::vector<std::unique_ptr<io::OutputFile>> files_;
};

}  // namespace limn::cli
