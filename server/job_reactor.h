// SPDX-License-Identifier: MIT
// One stream that runs a job: takes the upload, has the job computed, hands out the answer, to more
// input if the rpc takes any.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "engine/base/context.h"
#include "server/caller.h"
#include "server/client_watch.h"
#include "server/job_rpcs.h"
#include "server/job_run.h"
#include "server/service_core.h"

namespace limn {

// Reactions run on gRPC's few threads and never block: the job runs in the lane, messages are
// encoded by the delivery threads, and a message is encoded only when one has been taken, so that
// no thread ever waits for a reader. At most one read and one write are under way; Finish is called
// once, and not while a write is under way. It owns itself until OnDone; tasks share it.
//
// One mutex guards everything. gRPC's Start... and Finish are called with it held, which is what
// keeps their order: their reactions always run on a thread of gRPC, never inside the call.
//
// After the upload at most one message of input waits beside the one that the job works on; while
// it does, nothing is read, so that gRPC holds the sender back.
//
// Rpc: one of server/job_rpcs.h.
template <class Rpc>
class JobReactor final
    : public grpc::ServerBidiReactor<typename Rpc::Request, typename Rpc::Response>,
      public OpenStream,
      public std::enable_shared_from_this<JobReactor<Rpc>> {
 public:
  // For gRPC. core must outlive it.
  static JobReactor* Create(ServiceCore& core, grpc::CallbackServerContext* context);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void Stop(const absl::Status& status) override;
  void CheckStall(Clock::time_point now) override;

 private:
  using Request = typename Rpc::Request;
  using Response = typename Rpc::Response;
  using Lock = std::lock_guard<std::mutex>;
  enum class Phase { kHeader, kUpload, kQueued, kRunning, kDelivering };

  JobReactor(ServiceCore& core, grpc::CallbackServerContext* context);
  void Start();
  // With the mutex held.
  void ReadMore();

  // Messages of the client; in job_reactor_upload.cc. With the mutex held.
  [[nodiscard]] absl::Status TakeMessage();
  [[nodiscard]] absl::Status TakeHeader(const v1::InterpolateHeader& header);
  [[nodiscard]] absl::Status TakeChunk(const v1::MeshChunk& chunk);
  [[nodiscard]] absl::Status TakeInput();
  [[nodiscard]] absl::Status EndOfRequests();
  [[nodiscard]] absl::Status Enqueue();

  // Tasks of the lane and of the delivery threads. Without the mutex.
  void RunJob();
  void EncodeNext();
  void TakeProgress(const ProgressEvent& event);

  // Answer. With the mutex held.
  bool FeedJob();
  bool WaitsForInput() const;
  void PumpEncoder();
  void TryWrite();
  void Write(std::unique_ptr<Response> message);
  void WriteProgress();
  void End(const absl::Status& status);
  [[nodiscard]] absl::Status CheckTimes(Clock::time_point now) const;
  WorkerThreads& delivery();

  ServiceCore& core_;
  grpc::CallbackServerContext* const context_;
  const std::optional<Clock::time_point> deadline_;
  const Caller caller_;
  std::shared_ptr<JobReactor> self_;
  std::mutex mutex_;
  Phase phase_ = Phase::kHeader;
  ClientWatch watch_;

  Request request_;
  JobRun<Rpc> run_;
  const Clock::time_point start_;

  // Input after the upload.
  std::optional<Request> input_;
  bool input_ended_ = false;
  bool read_paused_ = false;

  // Answer.
  std::deque<std::unique_ptr<Response>> encoded_;
  std::unique_ptr<Response> writing_;
  std::optional<v1::Progress> progress_;
  Clock::time_point last_progress_;
  bool encoding_ = false;
  bool named_ = false;
  bool tile_seen_ = false;
  Clock::time_point write_start_;
  bool all_encoded_ = false;

  // End.
  std::optional<absl::Status> end_;
  Clock::time_point ended_at_;
  bool finished_ = false;
  bool done_ = false;
};

}  // namespace limn
