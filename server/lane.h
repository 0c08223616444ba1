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
  // A job's place in the lane, from its acceptance until it has been computed. Not thread-safe
  // itself. The lane must outlive it.
  class Place {
   public:
    Place() = default;
    Place(Place&& other) noexcept;
    Place& operator=(Place&& other) noexcept;
    ~Place() { Release(); }

    // How many jobs had to end before this one could start, when it was reserved.
    std::uint64_t position() const { return position_; }

    // Runs the job when its turn comes. Once per place.
    void Post(WorkerThreads::Task task);

    // Gives the place back, and takes the task back if it still waits. Safe to call again.
    void Release();

   private:
    friend class Lane;
    Place(Lane* lane, std::uint64_t position) : lane_(lane), position_(position) {}

    Lane* lane_ = nullptr;
    std::uint64_t position_ = 0;
    WorkerThreads::TaskId task_ = 0;
  };

  explicit Lane(const LaneOptions& options);

  // A place, or LIMIT_EXCEEDED with limit "queue-length" when workers + queue_length are taken.
  [[nodiscard]] absl::StatusOr<Place> Reserve();

  // Places taken now.
  std::uint64_t places_taken() const;

  // As those of WorkerThreads.
  [[nodiscard]] bool StopUntil(std::chrono::steady_clock::time_point until) {
    return threads_.StopUntil(until);
  }
  void Stop() { threads_.Stop(); }

 private:
  const LaneOptions options_;
  WorkerThreads threads_;
  mutable std::mutex mutex_;
  std::uint64_t taken_ = 0;
};

}  // namespace limn
