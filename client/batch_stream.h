// SPDX-License-Identifier: MIT
// One stream of a batch: what is sent on it, and what is read from it.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>
#include <string>

#include "client/batch.h"
#include "client/batch_ledger.h"
#include "client/batch_reporter.h"
#include "client/client.h"
#include "limn/v1/batch.pb.h"

namespace limn {

using BatchRpc = grpc::ClientReaderWriter<v1::BatchRequest, v1::BatchResponse>;

// Sends jobs, cancellations and acknowledgements as the ledger says. On a thread of its own.
class BatchSender {
 public:
  struct Source {
    const BatchCallbacks& callbacks;
    const ClientOptions& client;
    // Of the batch.
    std::string name;
    // The server's limit.
    std::uint64_t max_message_bytes = 0;
  };
  // All of them outlive it.
  BatchSender(const Source& source, BatchLedger* ledger, BatchReporter* reporter)
      : source_(source), ledger_(ledger), reporter_(reporter) {}

  // Until all is sent and answered, or the stream breaks.
  void Run(BatchRpc* stream);

 private:
  void Take();
  [[nodiscard]] absl::StatusOr<std::shared_ptr<OpenJob>> Open(BatchJob job) const;
  // False: the stream has broken.
  [[nodiscard]] bool Send(const OpenJob& job, BatchRpc* stream);

  Source source_;
  BatchLedger* ledger_;
  BatchReporter* reporter_;
};

// Reads all answers of a stream, puts them together, and reports jobs that have ended. Returns
// whether any job came further.
[[nodiscard]] bool ReadBatchAnswers(BatchRpc* stream, BatchLedger* ledger, BatchReporter* reporter);

}  // namespace limn
