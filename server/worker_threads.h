// SPDX-License-Identifier: MIT
// A few threads that run tasks, fairly between clients.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "engine/base/parallel.h"
#include "server/fair_queue.h"

namespace limn {

// Thread-safe. How many tasks may wait is the callers' to bound.
class WorkerThreads {
 public:
  using Task = std::function<void()>;
  // Number of a posted task; never 0.
  using TaskId = std::uint64_t;

  struct Options {
    // 1 or more.
    int count = 1;
    // Where tasks run; without one, each thread runs its tasks in a serial arena of its own.
    std::shared_ptr<ThreadArena> arena = nullptr;
    // Added to the threads' nice value (setpriority(2)), 0 to 19: others come first when processors
    // are scarce.
    int niceness = 0;
    // After so long a task goes before all others; see FairQueue.
    std::chrono::steady_clock::duration patience = std::chrono::seconds(30);
  };
  explicit WorkerThreads(const Options& options);
  ~WorkerThreads();
  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  // Runs the task when its client's turn comes; tasks of one client run in their order. Must not be
  // called after Stop. The task must not throw.
  TaskId Post(Task task, const std::string& client = "", std::uint64_t cost = 1);

  // Takes a task back that has not started. False: it runs, has run, or never was.
  bool Remove(TaskId id);

  // Has the threads end once they have run what was posted, and waits for them until then. False:
  // some still run.
  [[nodiscard]] bool StopUntil(std::chrono::steady_clock::time_point until);

  // The same without an end to the patience. Further calls do nothing.
  void Stop();

 private:
  void Run();

  const Options options_;
  std::mutex mutex_;
  std::condition_variable posted_;
  FairQueue queue_;
  std::unordered_map<TaskId, Task> tasks_;
  TaskId last_id_ = 0;
  bool stopping_ = false;
  // Threads that have not ended, and who waits for them.
  int alive_;
  std::condition_variable ended_;
  std::vector<std::thread> threads_;
};

}  // namespace limn
