// SPDX-License-Identifier: MIT
// What became of a batch, for a person and for a program.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/cli/batch_manifest.h"

namespace limn::cli {

// What became of a job.
struct BatchOutcome {
  // kSkipped: done before. kLeft: the batch ended first.
  enum class State { kLeft, kSucceeded, kFailed, kSkipped };
  State state = State::kLeft;
  std::string reason = "";
  std::string message = "";
  double seconds = 0;
  std::uint32_t tries = 0;
  std::uint64_t given_vertices = 0;
  std::uint64_t surface_vertices = 0;
};

struct BatchCounts {
  std::uint64_t succeeded = 0;
  std::uint64_t failed = 0;
  std::uint64_t skipped = 0;
  std::uint64_t left = 0;
};

[[nodiscard]] BatchCounts CountOutcomes(const std::vector<BatchOutcome>& outcomes);

// A word for why a job failed: the engine's reason, or the code of another error.
[[nodiscard]] std::string ReasonOf(const absl::Status& status);

// A short table: jobs, what became of them, why they failed, vertices, time, jobs per second.
[[nodiscard]] std::string BatchTable(const std::vector<BatchOutcome>& outcomes, double seconds);

// The same and every job, as JSON. outcomes: one for each of the entries.
[[nodiscard]] std::string BatchJson(const std::vector<BatchEntry>& entries,
                                    const std::vector<BatchOutcome>& outcomes, double seconds);

}  // namespace limn::cli
