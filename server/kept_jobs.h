// SPDX-License-Identifier: MIT
// The jobs of batches that survive their streams: which are attached to one, and which wait for
// their client to come back.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "server/batch_job.h"

namespace limn {

// Jobs are known by their client and their id. Thread-safe.
class KeptJobs {
 public:
  using Clock = std::chrono::steady_clock;

  // seconds: how long a job without a stream is kept.
  explicit KeptJobs(std::uint64_t seconds) : time_(std::chrono::seconds(seconds)) {}

  enum class Answer {
    // There was none: from now on there is one that is attached.
    kNew,
    // Another stream has it.
    kElsewhere,
    // *job waited, and is the caller's now.
    kTakenUp,
  };
  // A stream has a job of this id and digest. One that waits and has another digest is ended.
  Answer Claim(const std::string& client, const std::string& id, const std::string& digest,
               std::shared_ptr<BatchJob>* job);
  // The stream is gone; its job waits from now on.
  void Keep(std::shared_ptr<BatchJob> job, Clock::time_point now);
  // Nobody wants it any more.
  void Forget(const BatchJob& job);

  // Ends those that have waited for too long.
  void Expire(Clock::time_point now);
  // Ends all that wait.
  void Clear() { Expire(Clock::time_point::max()); }
  // How many wait.
  std::size_t waiting() const;

 private:
  using Key = std::pair<std::string, std::string>;
  struct Entry {
    // Null: a stream has it.
    std::shared_ptr<BatchJob> job;
    Clock::time_point since;
  };

  const Clock::duration time_;
  mutable std::mutex mutex_;
  std::map<Key, Entry> entries_;
};

}  // namespace limn
