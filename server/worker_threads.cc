// SPDX-License-Identifier: MIT
#include "server/worker_threads.h"

#include <algorithm>
#include <utility>

namespace limn {

WorkerThreads::WorkerThreads(int count, std::shared_ptr<ThreadArena> arena)
    : arena_(std::move(arena)), alive_(count) {
  threads_.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) threads_.emplace_back([this] { Run(); });
}

WorkerThreads::~WorkerThreads() { Stop(); }

WorkerThreads::TaskId WorkerThreads::Post(Task task) {
  TaskId id = 0;
  {
    const std::lock_guard lock(mutex_);
    id = ++last_id_;
    tasks_.push_back({id, std::move(task)});
  }
  posted_.notify_one();
  return id;
}

bool WorkerThreads::Remove(TaskId id) {
  // Destroyed after the lock is gone: what the task holds may want to post or remove in turn.
  Task removed;
  const std::lock_guard lock(mutex_);
  const auto at = std::find_if(tasks_.begin(), tasks_.end(),
                               [id](const Entry& entry) { return entry.id == id; });
  if (at == tasks_.end()) return false;
  removed = std::move(at->task);
  tasks_.erase(at);
  return true;
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
  ThreadArena serial(1);
  ThreadArena& arena = arena_ != nullptr ? *arena_ : serial;
  for (;;) {
    Task task;
    {
      std::unique_lock lock(mutex_);
      posted_.wait(lock, [this] { return stopping_ || !tasks_.empty(); });
      if (tasks_.empty()) {
        --alive_;
        ended_.notify_all();
        return;
      }
      task = std::move(tasks_.front().task);
      tasks_.pop_front();
    }
    arena.Execute(task);
  }
}

}  // namespace limn
