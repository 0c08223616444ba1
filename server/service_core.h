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
#include "server/stream_registry.h"
#include "server/tokens.h"
#include "server/worker_threads.h"

namespace limn {

struct ServiceCore {
  ServiceCore(const ServerLimits& server_limits, int thread_count, std::shared_ptr<Log> server_log)
      : limits(server_limits),
        threads(thread_count),
        log(std::move(server_log)),
        delivery(static_cast<int>(server_limits.workers), nullptr),
        lane({.name = "jobs",
              .workers = server_limits.workers,
              .queue_length = server_limits.queue_length,
              .threads = thread_count}),
        admission(limits, lane) {}

  // Waits for the threads: what they run uses everything here.
  ~ServiceCore() {
    lane.Stop();
    delivery.Stop();
  }

  // Ends the threads, after what was posted has run, and waits for them until then. False: some
  // still run. No stream may be open.
  [[nodiscard]] bool StopUntil(std::chrono::steady_clock::time_point until) {
    const bool lane_ended = lane.StopUntil(until);
    return delivery.StopUntil(until) && lane_ended;
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
  // Make the messages of answers, one task per stream at a time, each a tile or a chunk at the
  // most: short tasks, so that no answer waits long behind another. Not the lane's threads: a
  // finished job's answer must not wait behind another job.
  WorkerThreads delivery;
  Lane lane;
  Admission admission;
};

}  // namespace limn
