// SPDX-License-Identifier: MIT
// Puts a load on a server: an open loop by a schedule, or a closed one of so many clients.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/client.h"
#include "client/load/load_call.h"
#include "client/load/mix.h"

namespace limn::load {

struct LoadOptions {
  // As in Client::ConnectSecurely.
  std::string server;
  ClientSecurity security;
  // Deadline and metadata of every job.
  ClientOptions client;
  // Connections, 1 or more, which take turns.
  std::uint64_t connections = 4;
  // An open loop: when jobs are to be sent.
  std::vector<double> arrivals;
  // Of an open loop: with so many under way no other is sent; it counts as dropped.
  std::uint64_t most_outstanding = 4096;
  // A closed loop instead: so many clients, each of which sends its next job when the last one has
  // ended, for so many seconds. 0: none.
  std::uint64_t clients = 0;
  double seconds = 0;
};

struct LoadResult {
  // Of every job that was sent, in the order in which they ended.
  std::vector<Sample> samples;
  // Jobs that were to be sent: an open loop's schedule, or what was sent.
  std::uint64_t offered = 0;
  // Of an open loop: not sent, or sent more than 10 ms after their time.
  std::uint64_t dropped = 0;
  std::uint64_t late = 0;
  // Time for which jobs were to be sent, and until the last one had ended.
  double sending_seconds = 0;
  double seconds = 0;
};

// Runs to its end. stop: looked at before each job; true ends the sending, and cancels what is
// under way. progress: called a few times a second with the jobs sent and ended until then; may be
// null. Errors: those of MakeChannel and ReadAuthorization; UNAVAILABLE when the server cannot be
// reached to begin with. Jobs' errors are in the samples.
[[nodiscard]] absl::StatusOr<LoadResult> RunLoad(
    const LoadOptions& options, Mix* mix, const std::atomic<bool>& stop,
    const std::function<void(std::uint64_t, std::uint64_t)>& progress = {});

}  // namespace limn::load
