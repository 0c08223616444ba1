// SPDX-License-Identifier: MIT
// Takes connections and hands them to gRPC, up to a number. gRPC's own listener knows no such
// limit, and does not recover when the process's descriptors run out (CVE-2023-4785): connections
// beyond the limit are closed at once here, and descriptors are never used up by them.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "absl/status/statusor.h"

namespace limn {

// Thread-safe.
class Listener {
 public:
  // Binds and listens; connections wait until Start. address: checked; names are resolved. Errors:
  // UNREACHABLE naming "listen".
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Listener>> Bind(
      const std::string& address, std::uint64_t max_connections);

  // Stops.
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return port_; }

  // From now on calls take(listening descriptor, descriptor), who owns the second one then, for
  // each connection.
  void Start(std::function<void(int listener, int fd)> take);
  // Takes no more connections; waits until `take` is not called any more.
  void Stop();

  // Connections that are open now, counted anew.
  std::uint64_t Connections() const;
  // Connections that were closed because there were too many.
  std::uint64_t refused() const { return refused_.load(); }

 private:
  Listener(int fd, int port, std::uint64_t max_connections)
      : fd_(fd), port_(port), max_connections_(max_connections) {}
  void Run();
  bool HasRoom();

  const int fd_;
  const int port_;
  const std::uint64_t max_connections_;
  std::function<void(int listener, int fd)> take_;
  // At least as many as are open: those counted last and those taken since.
  std::uint64_t at_most_ = 0;
  std::atomic<std::uint64_t> refused_{0};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace limn
