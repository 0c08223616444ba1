// SPDX-License-Identifier: MIT
// Calls what the caller of a batch wants to be called, one at a time.
#pragma once

#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "client/batch.h"
#include "client/batch_job.h"
#include "client/batch_ledger.h"

namespace limn {

// Thread-safe.
class BatchReporter {
 public:
  // Both outlive it.
  BatchReporter(const BatchCallbacks& callbacks, BatchLedger* ledger)
      : callbacks_(callbacks), ledger_(ledger) {}

  // A job of the ledger's, which is kReporting, has ended. acknowledge: the server is told when the
  // caller has taken the result. Should the caller not take it, all jobs end.
  void Report(const OpenJob& job, absl::StatusOr<JobResult> result, bool acknowledge);
  // A job that never came into the ledger.
  void ReportUnsent(const std::string& id, const absl::Status& status);
  void ShowProgress(const std::string& id, const v1::Progress& progress);
  // A job was taken from the source.
  void CountTaken();

 private:
  // Whether the caller has taken it.
  bool Call(BatchResult result);

  const BatchCallbacks& callbacks_;
  BatchLedger* ledger_;
  std::mutex mutex_;
  BatchTotals totals_;
  bool silent_ = false;
};

}  // namespace limn
