// SPDX-License-Identifier: MIT
// One job of a load test: sends it, takes the answer as its kind does, notes what happened when.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/client.h"
#include "client/load/mix.h"
#include "client/load/timers.h"
#include "limn/v1/limn.grpc.pb.h"

namespace limn::load {

// Times in seconds after the start of the test.
struct Sample {
  JobKind kind = JobKind::kSmall;
  // When it was to be sent, and was.
  double intended = 0;
  double sent = 0;
  // When the first and the last piece of the surface came; below 0: none did.
  double first_tile = -1;
  double last_tile = -1;
  double ended = 0;
  // "OK"; else the reason of the error, or the name of its code where it has none.
  std::string outcome = {};
  // Whether that is what its kind is to get.
  bool good = false;
  std::uint64_t vertices = 0;
  std::uint64_t bytes_sent = 0;
  std::uint64_t bytes_received = 0;
  // By the summary: stages and their milliseconds.
  std::vector<std::pair<std::string, double>> stages = {};
};

// What a call needs; all of it must outlive the call, which the timers hold last of all.
struct CallEnvironment {
  v1::LimnService::Stub* stub = nullptr;
  const ClientOptions* options = nullptr;
  Timers* timers = nullptr;
  std::chrono::steady_clock::time_point start;
};

// A call under way.
class RunningCall {
 public:
  virtual ~RunningCall() = default;
  // Thread-safe.
  virtual void Cancel() = 0;
};

// Starts the job; `done` is called once, on a thread of gRPC, when it has ended. cancel_after: for
// jobs that are cancelled. The call lives until then at the least.
std::shared_ptr<RunningCall> StartCall(const CallEnvironment& environment,
                                       std::shared_ptr<const PreparedJob> job, double intended,
                                       std::chrono::milliseconds cancel_after,
                                       std::function<void(Sample)> done);

}  // namespace limn::load
