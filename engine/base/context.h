// SPDX-License-Identifier: MIT
// What a running job carries through every phase: the wish to stop, progress, limits.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "absl/status/status.h"

namespace limn {

// Refinements that are ever taken.
inline constexpr std::uint32_t kMaxLevel = 10;

// Sizes above which a job is refused before anything is allocated for it. Defaults are those of
// the engine; a server sets its own.
struct Limits {
  // Vertices of the input.
  std::uint64_t max_vertices = std::uint64_t{1} << 28;
  // Corners (sum of arities) of the input.
  std::uint64_t max_corners = std::uint64_t{1} << 30;
  // Refinements.
  std::uint32_t max_level = kMaxLevel;
  // Bytes of the arrays that a job holds at once, by the engine's own estimate.
  std::uint64_t max_bytes = std::uint64_t{1} << 38;
};

// A stage's progress. `fraction` is in [0, 1]; `sweep` and `update` belong to the stage "solve".
struct ProgressEvent {
  std::string_view stage;
  double fraction = 0;
  std::uint32_t sweep = 0;
  double update = 0;
};

// Shared between the job and whoever may stop it. Copies refer to the same job. All functions but
// the setters are thread-safe; the setters are called before the job starts.
class Context {
 public:
  using Clock = std::chrono::steady_clock;
  using ProgressFunction = std::function<void(const ProgressEvent&)>;

  Context();
  explicit Context(const Limits& limits);

  const Limits& limits() const { return limits_; }

  // From this time on, phases end with DEADLINE_EXCEEDED.
  void set_deadline(Clock::time_point deadline);

  // Called from the thread that runs the job, between the chunks of work; must not block.
  void set_progress(ProgressFunction progress) { progress_ = std::move(progress); }

  // Asks the job to stop: every phase ends with CANCELLED within one chunk of work.
  void Cancel() const;

  // Whether the job should stop. Cheap enough for every chunk: one relaxed load, and a clock
  // reading when there is a deadline.
  bool stop_requested() const;

  // Ok, or CANCELLED, or DEADLINE_EXCEEDED.
  absl::Status Check() const;

  // Reports progress, if somebody listens.
  void Report(const ProgressEvent& event) const {
    if (progress_) progress_(event);
  }

 private:
  struct Shared {
    std::atomic<bool> cancelled{false};
  };
  std::shared_ptr<Shared> shared_;
  std::optional<Clock::time_point> deadline_;
  ProgressFunction progress_;
  Limits limits_;
};

}  // namespace limn
