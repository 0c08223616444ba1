// SPDX-License-Identifier: MIT
// What a batch has done, in the folder of its outputs: a line for each job that has ended.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace limn::cli {

// A file FOLDER/limn-batch.jsonl. It outlives a program that is killed: a line is written when the
// job's files are in their places, and one that was cut off counts as not written. Locked, so that
// there is one batch at a time. Not thread-safe, but for Find.
class BatchJournal {
 public:
  struct Record {
    std::string id;
    // Hexadecimal, of all that the job is made of.
    std::string digest;
    // "succeeded" or "failed".
    std::string status;
    std::string reason = "";
    std::vector<std::string> files = {};
  };

  // resume: go on with the one that there is, if there is one. Errors: INVALID_OPTION when there is
  // one and it is not to be gone on with, or another program has it; MALFORMED_FILE; those of the
  // system.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<BatchJournal>> Open(const std::string& folder,
                                                                          bool resume);
  ~BatchJournal();
  BatchJournal(const BatchJournal&) = delete;
  BatchJournal& operator=(const BatchJournal&) = delete;

  // The batch's own, made by chance when it began.
  const std::string& name() const { return name_; }
  const std::string& path() const { return path_; }
  // The digest with which the job of this id had succeeded when the journal was opened; null: it
  // had not.
  const std::string* Find(const std::string& id) const;
  // Errors: those of the system.
  [[nodiscard]] absl::Status Add(const Record& record);

  static std::string PathIn(const std::string& folder);

 private:
  BatchJournal(std::string path, int descriptor);
  [[nodiscard]] absl::Status Begin();
  [[nodiscard]] absl::Status Read(const std::string& text);
  [[nodiscard]] absl::Status ReadLine(const std::string& line, std::size_t number);
  [[nodiscard]] absl::Status Write(const std::string& line);

  std::string path_;
  int descriptor_;
  std::string name_;
  absl::flat_hash_map<std::string, std::string> done_;
};

}  // namespace limn::cli
