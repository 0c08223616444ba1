// SPDX-License-Identifier: MIT
// Turns SIGINT (Ctrl-C) and SIGTERM into a call on an ordinary thread.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <thread>

#include <csignal>

namespace limn::cli {

// From construction to destruction the first SIGINT or SIGTERM leads to one call of the function,
// on a thread of the watcher's own; a second signal ends the process at once, as if nobody
// watched. The handler itself only writes a byte into a pipe. One watcher at a time.
class InterruptWatcher {
 public:
  // on_interrupt: may block and take locks; called at most once.
  explicit InterruptWatcher(std::function<void()> on_interrupt);
  // Afterwards the function is not running and will not be called; signals are as they were.
  ~InterruptWatcher();
  InterruptWatcher(const InterruptWatcher&) = delete;
  InterruptWatcher& operator=(const InterruptWatcher&) = delete;

  // Whether a signal has come. Thread-safe.
  bool interrupted() const { return interrupted_.load(); }

 private:
  void Watch();

  std::function<void()> on_interrupt_;
  std::atomic<bool> interrupted_{false};
  std::array<int, 2> pipe_ = {-1, -1};
  struct sigaction old_int_ = {};
  struct sigaction old_term_ = {};
  std::thread thread_;
};

}  // namespace limn::cli
