// SPDX-License-Identifier: MIT
// A Batch call: takes job after job, as far as there is room, and sends their answers as they
// come.
#pragma once

#include <grpcpp/server_context.h>
#include <grpcpp/support/server_callback.h>

#include <chrono>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "limn/v1/batch.pb.h"
#include "server/batch_job.h"
#include "server/caller.h"
#include "server/client_watch.h"
#include "server/kept_jobs.h"
#include "server/service_core.h"

namespace limn {

// As JobReactor, it never blocks a reaction, has at most one read and one write under way, calls
// Finish once, and owns itself until OnDone. While a part of an upload waits for room, or nobody
// takes the messages, no further part is read, so that gRPC holds the client back. Messages are
// encoded when there is room for them in `outbox_`, one for each job at a time, job after job.
//
// Its mutex may be held when a job's is taken, not the other way round.
class BatchReactor final : public grpc::ServerBidiReactor<v1::BatchRequest, v1::BatchResponse>,
                           public OpenStream,
                           public BatchJob::Stream,
                           public std::enable_shared_from_this<BatchReactor> {
 public:
  using Clock = std::chrono::steady_clock;

  // For gRPC. core and kept must outlive it.
  static BatchReactor* Create(ServiceCore& core, KeptJobs& kept,
                              grpc::CallbackServerContext* context);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  void Stop(const absl::Status& status) override;
  void CheckStall(Clock::time_point now) override;

  void JobReady(const std::shared_ptr<BatchJob>& job) override;

 private:
  using Lock = std::lock_guard<std::mutex>;
  using JobPointer = std::shared_ptr<BatchJob>;
  // What the last part of an upload waits for.
  enum class Waiting { kNothing, kToBeAdmitted, kForPlace };
  struct Entry {
    JobPointer job;
    // It is in ready_, or its next message is being made.
    bool queued = false;
  };
  struct AnsweredJob {
    JobPointer job;
    Clock::time_point since;
  };

  BatchReactor(ServiceCore& core, KeptJobs& kept, grpc::CallbackServerContext* context);
  void Start();

  // All with the mutex held. What comes in; in batch_reactor_upload.cc.
  [[nodiscard]] absl::Status TakeMessage();
  [[nodiscard]] absl::Status TakePart(v1::BatchRequest part);
  [[nodiscard]] absl::Status TakeHeader(v1::BatchRequest part);
  [[nodiscard]] absl::Status TakeChunk(const v1::BatchRequest& part);
  void Cancel(const std::string& id);
  void Acknowledge(const std::string& id);
  void EndOfRequests();
  void Advance();
  [[nodiscard]] absl::Status GoOn();
  bool AdmitJob();
  bool TakeUpJob();
  bool PlaceJob();
  bool WindowIsOpen() const;
  bool MayTryAgain(const absl::Status& status) const;
  bool GiveUpAnAnswer(const absl::Status& for_want_of);
  void WaitFor(Waiting what);
  JobPointer EndUpload();

  // What goes out.
  void AddJob(const JobPointer& job);
  void Fail(const JobPointer& job, const absl::Status& status);
  void SendError(const std::string& id, const std::string& request_id, const absl::Status& status);
  void SendAccepted(const std::string& id, const v1::Accepted& accepted);
  void Ready(const JobPointer& job);
  void Answered(const JobPointer& job);
  void PumpEncoders();
  void TryWrite();
  bool WriteProgress();
  bool TotalsChanged() const { return told_ != received_ + succeeded_ + failed_; }
  void WriteTotals();
  void Write(std::unique_ptr<v1::BatchResponse> message);
  void End(const absl::Status& status);
  void Drop(JobPointer job);
  [[nodiscard]] absl::Status CheckTimes(Clock::time_point now) const;

  // A task of the delivery threads.
  void Encode(const JobPointer& job);

  ServiceCore& core_;
  KeptJobs& kept_;
  grpc::CallbackServerContext* const context_;
  const std::optional<Clock::time_point> deadline_;
  const Caller caller_;
  const Clock::time_point start_;
  std::shared_ptr<BatchReactor> self_;
  std::mutex mutex_;
  ClientWatch watch_;

  // Input. `held_` is the header that waits to be admitted, `deferred_` the part of an upload that
  // came behind what waits: nothing is read behind that. `admitting_` is the job that waits to be
  // admitted, once it is known to be a new one; `uploading_` the one whose mesh arrives or waits
  // for a place; `last_id_` the last one that had a header, whose chunks are dropped when it has
  // failed or was taken up.
  v1::BatchRequest request_;
  bool reading_ = false;
  bool input_ended_ = false;
  Waiting waiting_ = Waiting::kNothing;
  Clock::time_point waiting_since_;
  bool try_again_ = false;
  v1::BatchRequest held_;
  std::optional<v1::BatchRequest> deferred_;
  JobPointer admitting_;
  JobPointer uploading_;
  std::string last_id_;
  bool drop_chunks_ = false;

  // Jobs without a complete answer, and those of the others whose acknowledgement is missing.
  std::map<std::string, Entry> jobs_;
  std::deque<AnsweredJob> answered_;
  std::uint64_t received_ = 0;
  std::uint64_t succeeded_ = 0;
  std::uint64_t failed_ = 0;

  // Output. `ready_` are jobs that have something to encode.
  std::deque<JobPointer> ready_;
  std::size_t encoding_ = 0;
  std::deque<std::unique_ptr<v1::BatchResponse>> outbox_;
  std::unique_ptr<v1::BatchResponse> writing_;
  Clock::time_point write_start_;
  // A few times a second every job's progress is told, one after the other.
  bool progress_round_ = false;
  std::string progress_after_;
  std::uint64_t told_ = 0;
  bool named_ = false;

  // End.
  std::optional<absl::Status> end_;
  bool finished_ = false;
  bool done_ = false;
};

}  // namespace limn
