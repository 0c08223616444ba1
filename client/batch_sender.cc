// SPDX-License-Identifier: MIT
// The half of a batch's stream that goes to the server.
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/batch_stream.h"
#include "engine/base/error.h"
#include "proto/wire/chunks.h"

namespace limn {
namespace {

v1::BatchRequest HeaderRequest(const OpenJob& job) {
  v1::BatchRequest request;
  request.set_job_id(job.id);
  request.set_digest(job.digest);
  *request.mutable_request()->mutable_header() = job.upload.header;
  return request;
}

}  // namespace

void BatchSender::Run(BatchRpc* stream) {
  using Kind = BatchLedger::Step::Kind;
  for (;;) {
    const BatchLedger::Step step = ledger_->NextStep();
    switch (step.kind) {
      case Kind::kControl:
        if (!stream->Write(step.control)) return;
        break;
      case Kind::kSend:
        if (!Send(*step.job, stream)) return;
        break;
      case Kind::kDrop:
        reporter_->Report(*step.job, step.job->end, false);
        break;
      case Kind::kTake:
        Take();
        break;
      case Kind::kFinish:
        stream->WritesDone();
        return;
      case Kind::kStop:
        return;
    }
  }
}

void BatchSender::Take() {
  std::optional<BatchJob> job = source_.callbacks.next();
  if (!job.has_value()) return ledger_->NoMore();
  reporter_->CountTaken();
  const std::string id = job->id;
  const absl::StatusOr<std::shared_ptr<OpenJob>> open = Open(*std::move(job));
  if (!open.ok()) return reporter_->ReportUnsent(id, open.status());
  if (ledger_->Add(*open)) return;
  reporter_->ReportUnsent(id, MakeError(absl::StrCat("there is another job '", id, "'"),
                                        {.reason = Reason::kInvalidOption,
                                         .field = "job_id",
                                         .remedy = "Give every job its own"}));
}

absl::StatusOr<std::shared_ptr<OpenJob>> BatchSender::Open(BatchJob job) const {
  LIMN_ASSIGN_OR_RETURN(std::shared_ptr<OpenJob> open,
                        MakeOpenJob(std::move(job), source_.client, source_.name));
  // A message that is too large would end the stream with all its jobs.
  if (HeaderRequest(*open).ByteSizeLong() <= source_.max_message_bytes) return open;
  return MakeError("the header with the constraints is larger than a message may be",
                   {.reason = Reason::kLimitExceeded,
                    .field = "constraints",
                    .remedy = "Use fewer constraints, or raise the server's --max-message-bytes",
                    .limit = "max-message-bytes"});
}

bool BatchSender::Send(const OpenJob& job, BatchRpc* stream) {
  using Upload = BatchLedger::UploadStep;
  if (!stream->Write(HeaderRequest(job))) return false;
  wire::ChunkReader chunks(job.upload.mesh.bytes, job.upload.chunk_bytes);
  v1::BatchRequest request;
  request.set_job_id(job.id);
  v1::BatchRequest control;
  for (;;) {
    switch (ledger_->NextUploadStep(job, &control)) {
      case Upload::kControl:
        if (!stream->Write(control)) return false;
        break;
      case Upload::kChunk:
        if (!chunks.Next(request.mutable_request()->mutable_chunk())) return true;
        if (!stream->Write(request)) return false;
        break;
      case Upload::kSkip:
        return true;
      case Upload::kStop:
        return false;
    }
  }
}

}  // namespace limn
