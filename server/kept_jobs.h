// SPDX-License-Identifier: MIT
// The jobs of batches that survive their streams: which are attached to one, and which wait for
// their client to come back.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "server/batch_job.h"

namespace limn {

// Jobs are known by their client, their id and their digest, so that nobody gets or ends what is
// not the very same work of the same client. Thread-safe.
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
  // A stream has this job. One that waits but has failed counts as none.
  Answer Claim(const std::string& client, const std::string& id, const std::string& digest,
               std::shared_ptr<BatchJob>* job);
  // The stream is gone; its job waits from now on.
  void Keep(std::shared_ptr<BatchJob> job, Clock::time_point now);
  // Nobody wants it any more.
  void Forget(const BatchJob& job);

  // Ends those that have waited for too long, all times together, and hands them out: to give back
  // what they hold takes long.
  std::vector<std::shared_ptr<BatchJob>> Expire(Clock::time_point now);
  // Ends all that wait.
  std::vector<std::shared_ptr<BatchJob>> Clear() { return Expire(Clock::time_point::max()); }
  // How many wait.
  std::size_t waiting() const;

 private:
  using Key = std::tuple<std::string, std::string, std::string>;
  struct Entry {
    // Null: a stream has it.
    std::shared_ptr<BatchJob> job;
    Clock::time_point since;
    // Waited before.
    Clock::duration before{0};
  };

  const Clock::duration time_;
  mutable std::mutex mutex_;
  std::map<Key, Entry> entries_;
};

}  // namespace limn
