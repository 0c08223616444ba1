// SPDX-License-Identifier: MIT
// A lane: worker threads of its own, which enter a thread arena of its own, a bounded number of
// places for jobs, and threads that make their answers. (A shared arena lets large jobs starve
// small ones, whatever their priorities.)
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "absl/status/statusor.h"
#include "server/worker_threads.h"

namespace limn {

struct LaneOptions {
  // In errors, logs and metrics.
  std::string name;
  // Jobs that are computed at a time, 1 or more.
  std::uint64_t workers = 1;
  // What waits beside them: jobs, bytes and milliseconds as estimated for them.
  std::uint64_t queue_length = 0;
  std::uint64_t queue_bytes = ~std::uint64_t{0};
  std::uint64_t queue_milliseconds = ~std::uint64_t{0};
  // Threads of the arena, 1 or more.
  int threads = 1;
  // Of the threads that compute and deliver; see WorkerThreads.
  int niceness = 0;
  // After so long a waiting job goes before all others.
  std::chrono::steady_clock::duration patience = std::chrono::seconds(30);
};

// What a job asks of a lane.
struct LaneRequest {
  // Whose job it is: every client gets the same share of the lane.
  std::string client = {};
  // As estimated.
  std::uint64_t bytes = 0;
  std::uint64_t milliseconds = 1;
};

// Thread-safe.
class Lane {
 public:
  using Clock = std::chrono::steady_clock;

  // A job's place in the lane, from the end of its upload until it has been computed. Not
  // thread-safe itself. The lane must outlive it.
  class Place {
   public:
    Place() = default;
    Place(Place&& other) noexcept;
    Place& operator=(Place&& other) noexcept;
    ~Place() { Release(); }

    // Runs the job when its turn comes. Once per place.
    void Post(WorkerThreads::Task task);

    // The job has been told to stop; see Lane::StuckJobs. Safe to call again.
    void StopRequested(Clock::time_point now);

    // Gives the place back, and takes the task back if it still waits. Safe to call again.
    void Release();

   private:
    friend class Lane;
    Place(Lane* lane, std::uint64_t id) : lane_(lane), id_(id) {}

    Lane* lane_ = nullptr;
    std::uint64_t id_ = 0;
  };

  explicit Lane(const LaneOptions& options);

  // A place, or LIMIT_EXCEEDED with limit "queue-length" when workers + queue_length are taken, and
  // with "queue-bytes" or "queue-milliseconds" when the job would have to wait and those that do
  // leave it no room.
  [[nodiscard]] absl::StatusOr<Place> Reserve(const LaneRequest& request = {});

  // How many jobs have to end before one that would be reserved now could start, or the error of
  // Reserve. Nothing is taken.
  [[nodiscard]] absl::StatusOr<std::uint64_t> NextPosition(const LaneRequest& request = {}) const;

  const std::string& name() const { return options_.name; }
  std::uint64_t workers() const { return options_.workers; }

  // What is in it now.
  struct Load {
    std::uint64_t running = 0;
    std::uint64_t waiting = 0;
    std::uint64_t waiting_bytes = 0;
    std::uint64_t waiting_milliseconds = 0;
  };
  Load load() const;

  // Places taken now.
  std::uint64_t places_taken() const;

  // Jobs that still run though they were told to stop before `since`.
  std::uint64_t StuckJobs(Clock::time_point since) const;

  // Make the messages of answers, one task per stream at a time, each a tile or a chunk at the
  // most: short tasks, so that no answer waits long behind another. Not the workers: a finished
  // job's answer must not wait behind another job.
  WorkerThreads& delivery() { return delivery_; }

  // As those of WorkerThreads, for both kinds of threads.
  [[nodiscard]] bool StopUntil(Clock::time_point until);
  void Stop();

 private:
  struct Entry {
    LaneRequest request;
    WorkerThreads::TaskId task = 0;
    bool running = false;
    bool told = false;
    Clock::time_point told_at;
  };
  // With the mutex held.
  [[nodiscard]] absl::StatusOr<std::uint64_t> PositionOfNext(const LaneRequest& request) const;
  void StopWaiting(Entry* entry);

  const LaneOptions options_;
  WorkerThreads delivery_;
  WorkerThreads threads_;
  mutable std::mutex mutex_;
  std::unordered_map<std::uint64_t, Entry> places_;
  std::uint64_t last_id_ = 0;
  Load load_;
};

// The lanes of a server.
struct Lanes {
  Lane interactive;
  Lane batch;
  // Jobs of so many milliseconds and fewer are interactive.
  std::uint64_t interactive_milliseconds;

  Lane& For(std::uint64_t milliseconds) {
    return milliseconds <= interactive_milliseconds ? interactive : batch;
  }
};

}  // namespace limn
