// SPDX-License-Identifier: MIT
// Whether a client keeps up. A message now and then is no sign of life: who sends or takes a few
// bytes a second holds a slot and memory for as long as who stands still.
#pragma once

#include <chrono>
#include <cstdint>

namespace limn {

// Counts the time in which it is the client's turn, and the bytes that it moves. In every window of
// such time it has to move as many bytes as the rate says. Not thread-safe.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  // bytes_per_second: 0 asks for nothing.
  Pace(std::chrono::seconds window, std::uint64_t bytes_per_second)
      : window_(window), bytes_per_second_(static_cast<double>(bytes_per_second)) {}

  // The client's turn, until Pause. Safe to call again.
  void Resume(Clock::time_point now) {
    if (!running_) since_ = now;
    running_ = true;
  }

  // The turn is over, and has moved this many bytes.
  void Pause(Clock::time_point now, std::uint64_t bytes) {
    if (running_) spent_ += now - since_;
    running_ = false;
    bytes_ += bytes;
  }

  // Bytes moved without an end to the turn.
  void Add(std::uint64_t bytes) { bytes_ += bytes; }

  // False: a window has passed, and too little was moved in it. Begins the next one.
  [[nodiscard]] bool KeepsUp(Clock::time_point now) {
    const Clock::duration spent = spent_ + (running_ ? now - since_ : Clock::duration(0));
    if (spent < window_) return true;
    const double seconds = std::chrono::duration<double>(spent).count();
    const bool enough = static_cast<double>(bytes_) >= seconds * bytes_per_second_;
    spent_ = Clock::duration(0);
    since_ = now;
    bytes_ = 0;
    return enough;
  }

 private:
  const Clock::duration window_;
  const double bytes_per_second_;
  bool running_ = false;
  Clock::time_point since_;
  // Of this window.
  Clock::duration spent_{0};
  std::uint64_t bytes_ = 0;
};

}  // namespace limn
