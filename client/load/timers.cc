// SPDX-License-Identifier: MIT
#include "client/load/timers.h"

#include <utility>

namespace limn::load {

Timers::Timers() : thread_([this] { Run(); }) {}

Timers::~Timers() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Timers::At(Clock::time_point time, std::function<void()> f) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.emplace(time, std::move(f));
  }
  changed_.notify_all();
}

void Timers::Run() {
  std::unique_lock lock(mutex_);
  while (!ending_) {
    if (waiting_.empty()) {
      changed_.wait(lock);
    } else if (const auto first = waiting_.begin(); first->first > Clock::now()) {
      changed_.wait_until(lock, Clock::time_point(first->first));
    } else {
      const std::function<void()> f = std::move(first->second);
      waiting_.erase(first);
      lock.unlock();
      f();
      lock.lock();
    }
  }
}

}  // namespace limn::load
