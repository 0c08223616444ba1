// SPDX-License-Identifier: MIT
// What is known of the jobs of a batch: which are to be sent, which are under way, what else the
// server is to be told. The thread that sends, the one that reads and the one that watches the
// clock meet here.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/batch.h"
#include "client/batch_job.h"
#include "limn/v1/batch.pb.h"

namespace limn {

// Thread-safe.
class BatchLedger {
 public:
  // options: with a window.
  explicit BatchLedger(const BatchOptions& options) : options_(options) {}

  // What the sending thread is to do next.
  struct Step {
    enum class Kind {
      // Write `control`: a cancellation or an acknowledgement.
      kControl,
      // Send `job`, which is kSent from now on.
      kSend,
      // Report `job`, which is kReporting from now on, with its `end`: the server need not be
      // asked.
      kDrop,
      // Take a job from the source, and Add it or say NoMore.
      kTake,
      // All has been sent and answered.
      kFinish,
      // The stream has broken.
      kStop,
    };
    Kind kind = Kind::kStop;
    std::shared_ptr<OpenJob> job = {};
    v1::BatchRequest control = {};
  };
  // Waits until there is something to do. Cancellations and acknowledgements go first, then jobs in
  // their order, then new ones, so long as there is room.
  [[nodiscard]] Step NextStep();

  // What the sending thread is to do next while it uploads a job, whose header it has written.
  enum class UploadStep {
    // Write *control.
    kControl,
    // Write the next chunk.
    kChunk,
    // No more of this job is wanted.
    kSkip,
    // The stream has broken.
    kStop,
  };
  // Of a job that a server may know, waits until that has accepted it.
  [[nodiscard]] UploadStep NextUploadStep(const OpenJob& job, v1::BatchRequest* control);

  // Adds a job of the source. False: there is one of its name that has not ended.
  [[nodiscard]] bool Add(const std::shared_ptr<OpenJob>& job);
  void NoMore();

  // The job of this name if the stream that there is has it; nothing otherwise: an answer that came
  // twice, or that nobody waits for any more.
  [[nodiscard]] std::shared_ptr<OpenJob> FindSent(const std::string& id);
  void Accept(OpenJob* job, bool resumed);
  // Whether the job will be tried again; `status` is why it failed.
  [[nodiscard]] bool Retry(OpenJob* job, const absl::Status& status);
  // The job's answer is complete, and goes to the caller. Returns the end that it was to have, or
  // ok.
  absl::Status BeginReport(OpenJob* job);
  // It has been taken. acknowledge: the server is told.
  void EndReport(const OpenJob& job, bool acknowledge);
  // Tells the server to stop a job that the client has no more use for.
  void CancelSent(const OpenJob& job);

  // A stream begins: jobs may be sent. It has ended: none may, until BreakStream nothing changes.
  void OpenStream();
  void CloseStream();
  // After CloseStream, when nobody sends any more: jobs that the stream had are to be sent again,
  // but for those returned, which have seen too many streams break, and are kReporting, to end with
  // `status`.
  [[nodiscard]] std::vector<std::shared_ptr<OpenJob>> BreakStream(const absl::Status& status);

  // All jobs are to end with this, and no more are taken.
  void EndAll(const absl::Status& status);
  // Those first sent before `before` are. Whether the server has not confirmed the end of one of
  // them for kGrace.
  [[nodiscard]] bool EndOverdue(BatchClock::time_point before, const absl::Status& status);
  // Time that a server has to confirm that jobs, or the stream, have ended.
  static constexpr std::chrono::seconds kGrace{5};
  // All jobs that nobody reports yet; they are kReporting from now on.
  [[nodiscard]] std::vector<std::shared_ptr<OpenJob>> TakeAll();

  // Whether no job is left and none will come.
  [[nodiscard]] bool Done();
  // The end that EndAll was called with, or ok.
  [[nodiscard]] absl::Status end();
  // Waits until EndAll has been called, or Done: true; or a time has come: false.
  [[nodiscard]] bool WaitForEnd(BatchClock::time_point until);

  // The pause before the next of so many tries that failed in a row.
  [[nodiscard]] BatchClock::duration Pause(std::uint32_t failures) const;

 private:
  bool DoneLocked() const { return no_more_ && open_.empty() && controls_.empty(); }
  bool RoomLocked() const;
  std::optional<Step> FindStep(BatchClock::time_point* wake);
  void EndLocked(OpenJob* job, const absl::Status& status);

  const BatchOptions options_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, std::shared_ptr<OpenJob>> open_;
  std::map<std::uint64_t, std::shared_ptr<OpenJob>> waiting_;
  std::deque<v1::BatchRequest> controls_;
  std::uint64_t mesh_bytes_ = 0;
  std::uint64_t next_number_ = 0;
  bool streaming_ = false;
  bool no_more_ = false;
  absl::Status end_;
};

}  // namespace limn
