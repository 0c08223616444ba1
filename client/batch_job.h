// SPDX-License-Identifier: MIT
// A job of a batch between its source and its answer.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "client/batch.h"
#include "client/client_call.h"
#include "client/result_collector.h"

namespace limn {

using BatchClock = std::chrono::steady_clock;

// What does not change once it is made is read without a lock; `answer` belongs to the thread that
// reads answers, and the rest to BatchLedger.
struct OpenJob : std::enable_shared_from_this<OpenJob> {
  enum class State {
    // Waits to be sent, perhaps again.
    kWaiting,
    // Sent on the stream that there is, or being sent.
    kSent,
    // Its answer is with the caller.
    kReporting,
  };

  std::string id;
  MeshUpload upload;
  std::string digest;

  ResultCollector answer;

  State state = State::kWaiting;
  // Jobs are sent in this order.
  std::uint64_t number = 0;
  // Whether a server may have it from an earlier stream.
  bool known = false;
  // On this stream.
  bool accepted = false;
  bool resumed = false;
  std::uint32_t tries = 0;
  // Of the tries, those in a row that failed by no fault of the job, or took a server with them.
  std::uint32_t failures = 0;
  BatchClock::time_point not_before = {};
  BatchClock::time_point first_sent = {};
  // Not ok: it is to end with this, and the server has been told or will be.
  absl::Status end;
};

// Encodes the mesh. Errors: those of the mesh and of MeshUpload::Make; INVALID_OPTION for an id
// that is none.
[[nodiscard]] absl::StatusOr<std::shared_ptr<OpenJob>> MakeOpenJob(BatchJob job,
                                                                   const ClientOptions& options,
                                                                   std::string_view batch_name);

// SHA-256 of all that the job is. Thread-safe.
[[nodiscard]] std::string JobDigest(std::string_view batch_name, const MeshUpload& upload);

}  // namespace limn
