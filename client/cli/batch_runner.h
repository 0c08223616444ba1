// SPDX-License-Identifier: MIT
// The jobs of `limn batch` on their way: from files to the server, and from there to files.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "client/batch.h"
#include "client/cli/batch_journal.h"
#include "client/cli/batch_manifest.h"
#include "client/cli/batch_outputs.h"
#include "client/cli/batch_report.h"
#include "client/cli/progress_bar.h"

namespace limn::cli {

// What ClientBatch calls. Next may run at the same time as one of the others.
class BatchRunner {
 public:
  // All of them outlive it. A job that has succeeded by the journal, of the same input, constraints
  // and options, is left out if its files are there.
  BatchRunner(const std::vector<BatchEntry>& entries, const BatchOutputs& outputs,
              BatchJournal* journal, ProgressBar* bar);

  // Reads the next job's files.
  std::optional<BatchJob> Next();
  // Writes its results, and then a line of the journal. Not ok: no result can be written any more.
  absl::Status Take(BatchResult result);
  void Show(const std::string& id, const v1::Progress& progress);

  // For each entry, when the batch is over.
  std::vector<BatchOutcome> outcomes() const;

 private:
  // Whether it is done already. digest: what it is to be done with.
  bool IsDone(const BatchEntry& entry, const std::string& digest) const;
  absl::StatusOr<v1::InterpolateHeader> MakeHeader(const BatchEntry& entry) const;
  absl::Status Write(const BatchEntry& entry, const JobResult& result);
  absl::Status Succeed(std::size_t index, const JobResult& result, BatchOutcome* outcome);
  absl::Status Fail(std::size_t index, const absl::Status& status, BatchOutcome* outcome);
  void ShowTotals(const std::string& note);
  std::string DigestAt(std::size_t index) const;

  const std::vector<BatchEntry>& entries_;
  const BatchOutputs& outputs_;
  BatchJournal* journal_;
  ProgressBar* bar_;
  absl::flat_hash_map<std::string, std::size_t> index_of_;
  std::size_t next_ = 0;
  // Never held while files are read or written, so that the two go on at the same time.
  mutable std::mutex mutex_;
  BatchCounts counts_;
  std::vector<BatchOutcome> outcomes_;
  std::vector<std::string> digests_;
};

// The id that a job has at the server: its own, or one made of it where that is not of 1 to 128
// visible ASCII characters.
[[nodiscard]] std::string WireId(const std::string& id);

}  // namespace limn::cli
