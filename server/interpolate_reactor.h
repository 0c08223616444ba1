// SPDX-License-Identifier: MIT
// One Interpolate stream: takes the upload, has the job computed, hands out the answer.
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
#include "limn/v1/interpolate.pb.h"
#include "proto/wire/chunks.h"
#include "server/job.h"
#include "server/service_core.h"

namespace limn {

// Reactions run on gRPC's few threads and never block: the job runs in the lane, messages are
// encoded by the delivery threads, and a message is encoded only when one has been taken, so that
// no thread ever waits for a reader. At most one read and one write are under way; Finish is called
// once, and not while a write is under way. It owns itself until OnDone; tasks share it.
//
// One mutex guards everything. gRPC's Start... and Finish are called with it held, which is what
// keeps their order: their reactions always run on a thread of gRPC, never inside the call.
class InterpolateReactor final
    : public grpc::ServerBidiReactor<v1::InterpolateRequest, v1::InterpolateResponse>,
      public OpenStream,
      public std::enable_shared_from_this<InterpolateReactor> {
 public:
  // For gRPC. core must outlive it.
  static InterpolateReactor* Create(ServiceCore& core, grpc::CallbackServerContext* context);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void Stop(const absl::Status& status) override;
  void CheckStall(Clock::time_point now) override;

 private:
  using Lock = std::lock_guard<std::mutex>;
  enum class Phase { kHeader, kUpload, kQueued, kRunning, kDelivering };

  InterpolateReactor(ServiceCore& core, grpc::CallbackServerContext* context);
  void Start();

  // Upload. With the mutex held.
  [[nodiscard]] absl::Status TakeMessage();
  [[nodiscard]] absl::Status TakeHeader(const v1::InterpolateHeader& header);
  [[nodiscard]] absl::Status TakeChunk(const v1::MeshChunk& chunk);
  [[nodiscard]] absl::Status EndOfUpload() const;
  [[nodiscard]] Context MakeContext();
  void Enqueue();

  // Tasks of the lane and of the delivery threads. Without the mutex.
  void RunJob();
  void EncodeNext();
  void TakeProgress(const ProgressEvent& event);

  // Answer. With the mutex held.
  void PumpEncoder();
  void TryWrite();
  void Write(std::unique_ptr<v1::InterpolateResponse> message);
  void WriteProgress();
  void End(const absl::Status& status);
  [[nodiscard]] absl::Status CancelledStatus() const;
  void LogEnd();

  ServiceCore& core_;
  grpc::CallbackServerContext* const context_;
  const std::optional<Clock::time_point> deadline_;
  std::shared_ptr<InterpolateReactor> self_;
  std::mutex mutex_;
  Phase phase_ = Phase::kHeader;
  Clock::time_point last_activity_;

  // Upload.
  v1::InterpolateRequest request_;
  std::string request_id_;
  JobSpec spec_;
  std::optional<wire::ChunkAssembler> upload_;
  Clock::time_point phase_start_;

  // Job. `stop_` reaches it while it runs.
  Admission::Ticket ticket_;
  Context stop_;
  std::unique_ptr<Job> job_;

  // Answer.
  std::deque<std::unique_ptr<v1::InterpolateResponse>> encoded_;
  std::unique_ptr<v1::InterpolateResponse> writing_;
  std::optional<v1::Progress> progress_;
  Clock::time_point last_progress_;
  bool encoding_ = false;
  bool all_encoded_ = false;

  // End.
  std::optional<absl::Status> end_;
  bool finished_ = false;
  bool done_ = false;
};

}  // namespace limn
