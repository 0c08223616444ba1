// SPDX-License-Identifier: MIT
// Finds clients that keep the server waiting: those that stand still, and those that crawl. A
// message now and then is no sign of life: who sends or takes a few bytes a second holds an
// upload's slot, or an answer's memory, for as long as who stands still.
#pragma once

#include <chrono>
#include <cstdint>

#include "absl/status/status.h"
#include "server/limits.h"

namespace limn {

// How much a client moves while it is its turn: in every window of such time it has to move as many
// bytes as the rate says. Not thread-safe.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;

  // bytes_per_second: 0 demands nothing.
  Pace(std::chrono::seconds window, std::uint64_t bytes_per_second)
      : window_(window), bytes_per_second_(static_cast<double>(bytes_per_second)) {}

  // The client's turn begins. Safe to call again.
  void Resume(Clock::time_point now);
  // The client's turn ends. Safe to call again.
  void Pause(Clock::time_point now);
  // Counts only while it is the client's turn.
  void Add(std::uint64_t bytes) { bytes_ += running_ ? bytes : 0; }

  // False: a window of the client's turns has passed in which it moved too little. Then the next
  // window begins.
  [[nodiscard]] bool KeepsUp(Clock::time_point now);

 private:
  const Clock::duration window_;
  const double bytes_per_second_;
  bool running_ = false;
  Clock::time_point since_;
  // Of this window.
  Clock::duration spent_{0};
  std::uint64_t bytes_ = 0;
};

// Watches the client of one stream. Not thread-safe.
class ClientWatch {
 public:
  using Clock = std::chrono::steady_clock;

  ClientWatch(const ServerLimits& limits, Clock::time_point now);

  // The client did something, or its turn begins.
  void Touch(Clock::time_point now) { last_activity_ = now; }
  void BeginUpload(Clock::time_point now) { upload_.Resume(now); }
  void Uploaded(std::uint64_t bytes) { upload_.Add(bytes); }
  // The upload has ended or has to wait, and others may follow.
  void PauseUpload(Clock::time_point now) { upload_.Pause(now); }
  // The mesh is complete: from now on at the latest a client has to read.
  void EndUpload(Clock::time_point now);

  // A message waits to be taken, or the end does. answer: whether it is part of the answer, whose
  // pace counts.
  void BeginWrite(Clock::time_point now, bool answer);
  // It has been taken.
  void EndWrite(Clock::time_point now, std::uint64_t bytes);

  // What the server waits for.
  struct Waiting {
    // For a message or the end to be taken. Not while a mesh is uploaded: there are clients that
    // read only after it.
    bool for_reader = false;
    // For the client's next message.
    bool for_message = false;
    // For the mesh to be complete.
    bool for_upload = false;
  };
  // Ok, or LIMIT_EXCEEDED with limit stall-seconds or min-bytes-per-second.
  [[nodiscard]] absl::Status Check(Clock::time_point now, const Waiting& waiting);

 private:
  const std::uint64_t stall_seconds_;
  const std::uint64_t bytes_per_second_;
  Clock::time_point last_activity_;
  Clock::time_point write_start_;
  Pace upload_;
  Pace answer_;
};

}  // namespace limn
