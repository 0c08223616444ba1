// SPDX-License-Identifier: MIT
// The half of a batch's stream that comes from the server.
#include <memory>
#include <utility>

#include "client/batch_stream.h"
#include "client/result_collector.h"
#include "engine/base/error.h"
#include "proto/wire/status.h"

namespace limn {
namespace {

class Reader {
 public:
  Reader(BatchLedger* ledger, BatchReporter* reporter) : ledger_(ledger), reporter_(reporter) {}

  // Whether it is about a job.
  bool Take(v1::BatchResponse message) {
    const std::shared_ptr<OpenJob> job = ledger_->FindSent(message.job_id());
    if (job == nullptr) return false;
    if (message.has_error()) {
      Fail(job.get(), wire::FromRichStatus(message.error()));
      return true;
    }
    if (!message.has_response()) return false;
    Take(job.get(), std::move(*message.mutable_response()));
    return true;
  }

 private:
  void Fail(OpenJob* job, const absl::Status& status) {
    if (ledger_->Retry(job, status)) return;
    const absl::Status end = ledger_->BeginReport(job);
    reporter_->Report(*job, end.ok() ? status : end, true);
  }

  void Take(OpenJob* job, v1::InterpolateResponse part) {
    if (part.has_progress()) return reporter_->ShowProgress(job->id, part.progress());
    if (part.has_accepted()) {
      job->answer = ResultCollector();
      return ledger_->Accept(job, part.accepted().resumed());
    }
    const bool last = part.has_summary();
    const absl::Status added = job->answer.Add(std::move(part));
    if (!added.ok()) {
      ledger_->CancelSent(*job);
      (void)ledger_->BeginReport(job);
      return reporter_->Report(*job, added, true);
    }
    if (!last) return;
    // Though it may have been cancelled meanwhile.
    (void)ledger_->BeginReport(job);
    reporter_->Report(*job, job->answer.Finish(), true);
  }

  BatchLedger* ledger_;
  BatchReporter* reporter_;
};

}  // namespace

bool ReadBatchAnswers(BatchRpc* stream, BatchLedger* ledger, BatchReporter* reporter) {
  Reader reader(ledger, reporter);
  bool further = false;
  v1::BatchResponse message;
  while (stream->Read(&message)) further = reader.Take(std::move(message)) || further;
  return further;
}

}  // namespace limn
