// SPDX-License-Identifier: MIT
// The streams that are open, for those who must end them: draining and the watch for stalls.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "absl/status/status.h"

namespace limn {

// An open stream, as the registry sees it. Thread-safe; none of these block.
class OpenStream {
 public:
  using Clock = std::chrono::steady_clock;
  virtual ~OpenStream() = default;
  // Ends the stream with this error, unless it is ending already.
  virtual void Stop(const absl::Status& status) = 0;
  // Called a few times a second: ends the stream when its client has been idle for too long.
  virtual void CheckStall(Clock::time_point now) = 0;
};

// Thread-safe.
class StreamRegistry {
 public:
  void Add(const std::shared_ptr<OpenStream>& stream);
  void Remove(const OpenStream* stream);
  // Waits until no stream is open. False: some were when the time had come.
  bool WaitUntilEmpty(OpenStream::Clock::time_point until);
  // Calls visit for the streams that are open now, without holding a lock.
  void ForEach(const std::function<void(OpenStream&)>& visit);
  std::size_t size() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable empty_;
  std::unordered_map<const OpenStream*, std::weak_ptr<OpenStream>> streams_;
};

}  // namespace limn
