// SPDX-License-Identifier: MIT
// A few threads that run tasks in the order in which they were posted.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "engine/base/parallel.h"

namespace limn {

// Thread-safe. How many tasks may wait is the callers' to bound.
class WorkerThreads {
 public:
  using Task = std::function<void()>;
  // Number of a posted task; never 0.
  using TaskId = std::uint64_t;

  // count: 1 or more. arena: where tasks run; without one, each thread runs its tasks in a serial
  // arena of its own.
  WorkerThreads(int count, std::shared_ptr<ThreadArena> arena);
  ~WorkerThreads();
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  // Runs the task soon. Must not be called after Stop. The task must not throw.
  TaskId Post(Task task);

  // Takes a task back that has not started. False: it runs, has run, or never was.
  bool Remove(TaskId id);

  // Has the threads end once they have run what was posted, and waits for them until then. False:
  // some still run.
  [[nodiscard]] bool StopUntil(std::chrono::steady_clock::time_point until);

  // The same without an end to the patience. Further calls do nothing.
  void Stop();

 private:
  struct Entry {
    TaskId id;
    Task task;
  };
  void Run();

  const std::shared_ptr<ThreadArena> arena_;
  std::mutex mutex_;
  std::condition_variable posted_;
  std::deque<Entry> tasks_;
  TaskId last_id_ = 0;
  bool stopping_ = false;
  // Threads that have not ended, and who waits for them.
  int alive_;
  std::condition_variable ended_;
  std::vector<std::thread> threads_;
};

}  // namespace limn
