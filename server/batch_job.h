// SPDX-License-Identifier: MIT
// One job of a batch, which may outlive the stream that it came on.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "limn/v1/batch.pb.h"
#include "server/job_run.h"

namespace limn {

// The upload is its stream's alone; everything after Enqueue is thread-safe.
class BatchJob final : public std::enable_shared_from_this<BatchJob> {
 public:
  using Clock = std::chrono::steady_clock;

  // What it tells its stream, on any thread and with no lock held.
  class Stream {
   public:
    virtual ~Stream() = default;
    // There is an answer or an error; see BeginEncode and error.
    virtual void JobReady(const std::shared_ptr<BatchJob>& job) = 0;
  };

  // core must outlive it. digest: empty for a job that ends with its stream.
  BatchJob(ServiceCore& core, const Caller& caller, std::string id, std::string digest);
  // Counts and logs it, unless its answer was made, which did.
  ~BatchJob();

  const std::string& id() const { return id_; }
  const std::string& digest() const { return digest_; }
  const std::string& request_id() const { return run_.request_id(); }
  // Of whom else it could be under the same id.
  const std::string& client() const { return client_; }
  // Where its messages are made. Not before a header was taken.
  WorkerThreads& delivery() { return run_.lane()->delivery(); }

  const std::string& lane_name() const { return run_.lane()->name(); }

  // As JobRun's.
  [[nodiscard]] absl::Status TakeHeader(const v1::InterpolateHeader& header,
                                        v1::Accepted* accepted);
  [[nodiscard]] absl::Status TakeChunk(const v1::MeshChunk& chunk) { return run_.TakeChunk(chunk); }
  bool upload_complete() const { return run_.upload_complete(); }
  std::uint64_t bytes_uploaded() const { return run_.bytes_uploaded(); }
  std::uint64_t bytes_expected() const { return run_.bytes_expected(); }
  [[nodiscard]] absl::Status Enqueue();

  // Whose it is from now on: its answer begins anew. What it has already it may tell or not.
  void Attach(const std::weak_ptr<Stream>& stream);
  // It is nobody's. True: it goes on, or has an answer. False: it has failed, or is not complete.
  [[nodiscard]] bool Detach();

  // Ends it with this error, unless it has failed or its answer is complete. True: it has failed
  // now. False: nothing was to be done, or something runs that sees it soon; then its stream, if it
  // has one, is told.
  bool Stop(const absl::Status& why);

  // What it reported last, once.
  std::optional<v1::Progress> TakeProgress();

  // Whether `stream` may make a message of its answer now; then it must call Encode, once, from
  // one thread.
  [[nodiscard]] bool BeginEncode(const Stream* stream);
  // The next message of its answer; the last one is the summary. Errors: those of Job::NextMessage,
  // after which it has failed.
  [[nodiscard]] absl::Status Encode(v1::InterpolateResponse* message);

  // Why it failed, if it did.
  absl::Status error() const;

 private:
  enum class Phase { kUpload, kQueued, kRunning, kAnswering, kAnswered, kFailed };
  using Lock = std::lock_guard<std::mutex>;

  void Run();
  void Report(const ProgressEvent& event);
  void Tell();

  ServiceCore& core_;
  const std::string id_;
  const std::string digest_;
  const std::string client_;
  const Clock::time_point start_;
  JobRun<BatchJobRpc> run_;

  mutable std::mutex mutex_;
  std::weak_ptr<Stream> stream_;
  Phase phase_ = Phase::kUpload;
  absl::Status error_;
  std::optional<v1::Progress> progress_;
  Clock::time_point stopped_at_;
  bool encoding_ = false;
  // Another stream wants the answer from its beginning, once nobody encodes.
  bool rewind_ = false;
  bool tile_seen_ = false;
  bool logged_ = false;
};

}  // namespace limn
