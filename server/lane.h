// SPDX-License-Identifier: MIT
// A lane: worker threads of its own, which enter a thread arena of its own, and a bounded number of
// places for jobs. (A shared arena lets large jobs starve small ones, whatever their priorities.)
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "server/worker_threads.h"

namespace limn {

struct LaneOptions {
  // In errors and logs.
  std::string name;
  // Jobs that are computed at a time, 1 or more.
  std::uint64_t workers = 1;
  // Jobs that wait beside them.
  std::uint64_t queue_length = 0;
  // Threads of the arena, 1 or more.
  int threads = 1;
};

// Thread-safe.
class Lane {
 public:
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

    // Gives the place back, and takes the task back if it still waits. Safe to call again.
    void Release();

   private:
    friend class Lane;
    explicit Place(Lane* lane) : lane_(lane) {}

    Lane* lane_ = nullptr;
    WorkerThreads::TaskId task_ = 0;
  };

  explicit Lane(const LaneOptions& options);

  // A place, or LIMIT_EXCEEDED with limit "queue-length" when workers + queue_length are taken.
  [[nodiscard]] absl::StatusOr<Place> Reserve();

  // How many jobs have to end before one that would be reserved now could start, or the error of
  // Reserve. Nothing is taken.
  [[nodiscard]] absl::StatusOr<std::uint64_t> NextPosition() const;

  // Places taken now.
  std::uint64_t places_taken() const;

  // As those of WorkerThreads.
  [[nodiscard]] bool StopUntil(std::chrono::steady_clock::time_point until) {
    return threads_.StopUntil(until);
  }
  void Stop() { threads_.Stop(); }

 private:
  // With the mutex held.
  [[nodiscard]] absl::StatusOr<std::uint64_t> PositionOfNext() const;

  const LaneOptions options_;
  WorkerThreads threads_;
  mutable std::mutex mutex_;
  std::uint64_t taken_ = 0;
};

}  // namespace limn
