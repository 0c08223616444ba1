// SPDX-License-Identifier: MIT
#include "client/batch_reporter.h"

#include <chrono>
#include <utility>

namespace limn {

bool BatchReporter::Call(BatchResult result) {
  const std::lock_guard lock(mutex_);
  if (silent_) return false;
  ++(result.result.ok() ? totals_.succeeded : totals_.failed);
  const absl::Status taken = callbacks_.on_result(std::move(result));
  if (!taken.ok()) {
    silent_ = true;
    ledger_->EndAll(taken);
    return false;
  }
  if (callbacks_.on_totals) callbacks_.on_totals(totals_);
  return true;
}

void BatchReporter::Report(const OpenJob& job, absl::StatusOr<JobResult> result, bool acknowledge) {
  const bool sent = job.first_sent != BatchClock::time_point{};
  const std::chrono::duration<double> passed = BatchClock::now() - job.first_sent;
  const bool taken = Call({.id = job.id,
                           .result = std::move(result),
                           .digest = job.digest,
                           .seconds = sent ? passed.count() : 0,
                           .tries = job.tries});
  ledger_->EndReport(job, taken && acknowledge);
}

void BatchReporter::ReportUnsent(const std::string& id, const absl::Status& status) {
  Call({.id = id, .result = status});
}

void BatchReporter::ShowProgress(const std::string& id, const v1::Progress& progress) {
  const std::lock_guard lock(mutex_);
  if (!silent_ && callbacks_.on_job_progress) callbacks_.on_job_progress(id, progress);
}

void BatchReporter::CountTaken() {
  const std::lock_guard lock(mutex_);
  ++totals_.taken;
  if (!silent_ && callbacks_.on_totals) callbacks_.on_totals(totals_);
}

}  // namespace limn
