// SPDX-License-Identifier: MIT
// Memory and processor time of a process on this machine, before, at the peak of and after a load
// (proc(5)).
#pragma once

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>

#include "absl/status/statusor.h"

namespace limn::load {

struct ProcessUse {
  std::uint64_t bytes_before = 0;
  std::uint64_t bytes_peak = 0;
  std::uint64_t bytes_after = 0;
  // User and system time between.
  double cpu_seconds = 0;
};

// Looks ten times a second.
class ProcessProbe {
 public:
  // Errors: NotFound when there is no such process.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<ProcessProbe>> Start(int pid);
  ~ProcessProbe();
  ProcessProbe(const ProcessProbe&) = delete;
  ProcessProbe& operator=(const ProcessProbe&) = delete;

  // What was seen since Start; a process that has ended has no bytes after.
  ProcessUse Stop();

 private:
  struct Look {
    std::uint64_t bytes = 0;
    double cpu_seconds = 0;
  };
  explicit ProcessProbe(int pid) : pid_(pid) {}
  bool LookNow(Look* look) const;
  void Watch();

  const int pid_;
  Look first_;
  ProcessUse use_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace limn::load
