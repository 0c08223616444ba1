// SPDX-License-Identifier: MIT
// Calls functions at given times, on one thread of its own.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>

namespace limn::load {

// Thread-safe.
class Timers {
 public:
  using Clock = std::chrono::steady_clock;

  Timers();
  // Waits for the function that runs; the others are not called any more.
  ~Timers();
  Timers(const Timers&) = delete;
  Timers& operator=(const Timers&) = delete;

  // f: short, since others wait for it.
  void At(Clock::time_point time, std::function<void()> f);

 private:
  void Run();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::multimap<Clock::time_point, std::function<void()>> waiting_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace limn::load
