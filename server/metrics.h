// SPDX-License-Identifier: MIT
// What an operator sees of a server: Prometheus metrics, over HTTP on a port of their own.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace limn {

// What a lane is doing.
struct LaneSample {
  std::string name;
  std::uint64_t waiting = 0;
  std::uint64_t waiting_milliseconds = 0;
  std::uint64_t running = 0;
  std::uint64_t stuck = 0;
};

// What is looked at when metrics are asked for.
struct ServerSample {
  bool draining = false;
  bool live = true;
  std::uint64_t streams = 0;
  std::uint64_t connections = 0;
  std::uint64_t uploads = 0;
  std::uint64_t reserved_bytes = 0;
  // Seconds since 1970; 0 without TLS.
  std::int64_t certificate_expiry = 0;
  std::vector<LaneSample> lanes;
};

// Thread-safe. All labels come from closed lists: no client can make new time series.
class Metrics {
 public:
  Metrics();
  ~Metrics();
  Metrics(const Metrics&) = delete;
  Metrics& operator=(const Metrics&) = delete;

  // A call has ended.
  void CountRequest(std::string_view method, const absl::Status& status);
  // A job was refused or ended because of a limit before it ran; nothing for other errors.
  void CountAdmissionReject(const absl::Status& status);
  // A mesh did not decode.
  void CountDecodeReject(const absl::Status& status);
  void ObserveQueueWait(std::string_view lane, double seconds);
  void ObserveStage(std::string_view stage, double seconds);
  // From the beginning of a call to its first tile.
  void ObserveFirstTile(double seconds);
  // From a job's end by cancel, deadline or error to the last of its threads being free.
  void ObserveCancelToStop(double seconds);
  // Time in which a message waited for its client to take it.
  void AddStall(double seconds);
  // Bytes of answers that are made and not taken yet.
  void AddInflight(std::int64_t bytes);

  // Called for each scrape. Before Listen and Text.
  void SetSampler(std::function<ServerSample()> sampler);

  // All metrics, in Prometheus' text format.
  [[nodiscard]] std::string Text() const;

  // Answers http://address/metrics from now on. Returns the port. Errors: UNREACHABLE.
  [[nodiscard]] absl::StatusOr<int> Listen(const std::string& address);
  // Ends that. Waits for scrapes that are under way.
  void StopListening();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limn
