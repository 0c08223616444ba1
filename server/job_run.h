// SPDX-License-Identifier: MIT
// One job on its way through the server, from its header to the last message of its answer,
// whatever stream it came on: admission, upload, computing, what is counted and logged of it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "limn/v1/interpolate.pb.h"
#include "proto/wire/chunks.h"
#include "server/admission.h"
#include "server/caller.h"
#include "server/job_rpcs.h"
#include "server/service_core.h"

namespace limn {

// The event as the message that clients get.
inline v1::Progress ProgressOf(const ProgressEvent& event) {
  v1::Progress progress;
  progress.set_stage(std::string(event.stage));
  progress.set_fraction(event.fraction);
  progress.set_sweep(event.sweep);
  progress.set_residual(event.update);
  return progress;
}

// The steps, in order: TakeHeader, TakeChunk until upload_complete, Enqueue, BeginRun, Compute,
// EndRun, NextMessage until there is none. The stream that has the job holds its own mutex in all
// but Compute and NextMessage, which take long, and runs one of them at a time.
//
// Rpc: one of server/job_rpcs.h.
template <class Rpc>
class JobRun {
 public:
  using Clock = std::chrono::steady_clock;
  using Response = typename Rpc::Response;

  // core must outlive it.
  JobRun(ServiceCore& core, Caller caller, std::optional<Clock::time_point> deadline);

  // Admits the job; what to tell of it is left in *accepted. A header without a name gets the
  // call's. Errors: those of Rpc::Spec and Admission::Admit; it can be tried again after a
  // retryable one. Errors of this and of Enqueue that are passed on are the caller's to count.
  [[nodiscard]] absl::Status TakeHeader(const v1::InterpolateHeader& header,
                                        v1::Accepted* accepted);

  // Errors: those of wire::ChunkAssembler::Add.
  [[nodiscard]] absl::Status TakeChunk(const v1::MeshChunk& chunk) { return upload_->Add(chunk); }
  bool upload_complete() const { return upload_->complete(); }
  // How much of how much has come.
  std::uint64_t bytes_uploaded() const { return upload_->bytes().size(); }
  std::uint64_t bytes_expected() const { return spec_.mesh.byte_count(); }

  // For a complete upload: has `task` run on one of the lane's threads when the job's turn comes.
  // Errors: those of Admission::Enqueue; it can be tried again after a retryable one.
  [[nodiscard]] absl::Status Enqueue(const std::function<void(const ProgressEvent&)>& progress,
                                     WorkerThreads::Task task);

  // At the beginning and at the end of `task`. Compute's errors: those of decoding and of the job.
  void BeginRun();
  [[nodiscard]] absl::Status Compute();
  void EndRun() { ticket_.place.Release(); }

  // As the job's.
  [[nodiscard]] absl::StatusOr<bool> NextMessage(Response* message);

  // Ends what runs, as soon as it sees it, and gives back what nothing needs any more. running:
  // between BeginRun and EndRun. Safe to call again.
  void Stop(bool running, Clock::time_point now);

  // For a job that waits for its turn: LIMIT_EXCEEDED with limit queue-seconds, once it has done so
  // for too long.
  [[nodiscard]] absl::Status CheckQueueTime(Clock::time_point now) const;

  // Counts the job's end, and writes its line of the log. at_rest: nothing runs. job_id: its name
  // in a batch; empty for none.
  void LogEnd(const absl::Status& status, bool at_rest, const std::string& job_id = "") const;

  const std::string& request_id() const { return request_id_; }
  // Null before TakeHeader.
  Lane* lane() const { return ticket_.lane; }
  // Null before Enqueue.
  typename Rpc::Job* job() const { return job_.get(); }

 private:
  [[nodiscard]] absl::Status Grow(std::uint64_t bytes);
  void SetCounts(const v1::MeshHeader& mesh);

  ServiceCore& core_;
  const Caller caller_;
  const std::optional<Clock::time_point> deadline_;
  std::string request_id_;
  JobSpec spec_;
  std::optional<wire::ChunkAssembler> upload_;
  Clock::time_point phase_start_;
  Admission::Ticket ticket_;
  Context stop_;
  std::unique_ptr<typename Rpc::Job> job_;
  // What is known of the mesh, for the log, also while the job runs.
  mutable std::mutex counts_mutex_;
  std::uint64_t vertices_ = 0;
  std::uint64_t faces_ = 0;
};

}  // namespace limn
