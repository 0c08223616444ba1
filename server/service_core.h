// SPDX-License-Identifier: MIT
// What all streams of a server share.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <utility>

#include "server/admission.h"
#include "server/lane.h"
#include "server/limits.h"
#include "server/log.h"
#include "server/metrics.h"
#include "server/stream_registry.h"
#include "server/tokens.h"

namespace limn {

[[nodiscard]] inline LaneOptions LaneFrom(const ServerLimits& limits, const char* name, int threads,
                                          int niceness) {
  return {.name = name,
          .workers = limits.workers,
          .queue_length = limits.queue_length,
          .queue_bytes = limits.queue_bytes,
          .queue_milliseconds = limits.queue_milliseconds,
          .threads = threads,
          .niceness = niceness,
          .patience = std::chrono::milliseconds(500 * limits.queue_seconds)};
}

struct ServiceCore {
  // batch_niceness: of the threads of the batch lane.
  ServiceCore(const ServerLimits& server_limits, int thread_count, int batch_niceness,
              std::shared_ptr<Log> server_log)
      : limits(server_limits),
        threads(thread_count),
        log(std::move(server_log)),
        lanes{.interactive = Lane(LaneFrom(server_limits, "interactive", thread_count, 0)),
              .batch = Lane(LaneFrom(server_limits, "batch", thread_count, batch_niceness)),
              .interactive_milliseconds = server_limits.interactive_milliseconds},
        admission(limits, lanes) {}

  // Waits for the threads: what they run uses everything here.
  ~ServiceCore() {
    lanes.interactive.Stop();
    lanes.batch.Stop();
  }

  // Ends the threads, after what was posted has run, and waits for them until then. False: some
  // still run. No stream may be open.
  [[nodiscard]] bool StopUntil(std::chrono::steady_clock::time_point until) {
    const bool ended = lanes.interactive.StopUntil(until);
    return lanes.batch.StopUntil(until) && ended;
  }

  const ServerLimits limits;
  // Threads that jobs are computed on.
  const int threads;
  const std::shared_ptr<Log> log;
  // Set: new jobs are refused.
  std::atomic<bool> draining{false};
  // Null: calls need none. Set before the first call.
  std::unique_ptr<Tokens> tokens;
  StreamRegistry streams;
  Metrics metrics;
  Lanes lanes;
  Admission admission;
};

}  // namespace limn
