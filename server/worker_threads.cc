// SPDX-License-Identifier: MIT
#include "server/worker_threads.h"

#include <sys/resource.h>

#include <optional>
#include <utility>

namespace limn {

WorkerThreads::WorkerThreads(const Options& options)
    : options_(options), queue_(options.patience), alive_(options.count) {
  threads_.reserve(static_cast<std::size_t>(options.count));
  for (int i = 0; i < options.count; ++i) threads_.emplace_back([this] { Run(); });
}

WorkerThreads::~WorkerThreads() { Stop(); }

WorkerThreads::TaskId WorkerThreads::Post(Task task, const std::string& client,
                                          std::uint64_t cost) {
  TaskId id = 0;
  {
    const std::lock_guard lock(mutex_);
    id = ++last_id_;
    tasks_.emplace(id, std::move(task));
    queue_.Push(id, client, cost, FairQueue::Clock::now());
  }
  posted_.notify_one();
  return id;
}

bool WorkerThreads::Remove(TaskId id) {
  // Destroyed after the lock is gone: what the task holds may want to post or remove in turn.
  Task removed;
  const std::lock_guard lock(mutex_);
  const auto at = tasks_.find(id);
  if (at == tasks_.end()) return false;
  removed = std::move(at->second);
  tasks_.erase(at);
  return queue_.Remove(id);
}

bool WorkerThreads::StopUntil(std::chrono::steady_clock::time_point until) {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  posted_.notify_all();
  return ended_.wait_until(lock, until, [this] { return alive_ == 0; });
}

void WorkerThreads::Stop() {
  (void)StopUntil(std::chrono::steady_clock::now());
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void WorkerThreads::Run() {
  if (options_.niceness > 0) {
    // On Linux the nice value is one thread's, and 0 stands for the caller. Nobody is worse off
    // where it fails.
    const int now = getpriority(PRIO_PROCESS, 0);
    (void)setpriority(PRIO_PROCESS, 0, now + options_.niceness);
  }
  ThreadArena serial(1);
  ThreadArena& arena = options_.arena != nullptr ? *options_.arena : serial;
  for (;;) {
    Task task;
    {
      std::unique_lock lock(mutex_);
      posted_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
      const std::optional<FairQueue::Id> next = queue_.Pop(FairQueue::Clock::now());
      if (!next.has_value()) {
        --alive_;
        ended_.notify_all();
        return;
      }
      const auto at = tasks_.find(*next);
      task = std::move(at->second);
      tasks_.erase(at);
    }
    arena.Execute(task);
  }
}

}  // namespace limn
