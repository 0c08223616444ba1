// SPDX-License-Identifier: MIT
// The server: from start to stop.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/limits.h"
#include "server/log.h"
#include "server/tls.h"

namespace grpc {
class Channel;
}

namespace limn {

struct ServerOptions {
  // HOST:PORT to listen on, port 0 for a free one; empty for in-process channels only.
  std::string listen;
  // Allow addresses that other machines can reach though nothing is encrypted.
  bool insecure = false;
  // With a certificate, what is listened on speaks TLS only.
  TlsFiles tls;
  // File of bearer tokens, one of which every call of LimnService needs; see Tokens. It is read
  // again when it changes. Empty: calls need none. Health and reflection are open to everybody.
  std::string token_file;
  // HOST:PORT of the metrics' own port, as `listen`; never encrypted. Empty: none.
  std::string metrics_listen;
  // Threads that jobs are computed on, 0 to 1,024; 0 is CpuLimit().
  int threads = 0;
  ServerLimits limits;
  // Where events go. None: nowhere.
  std::shared_ptr<Log> log;
};

// Thread-safe.
class Server {
 public:
  // Serves when it returns, warmed up: every lane has computed a small job. Errors: INVALID_OPTION
  // naming the flag; UNREACHABLE when the address is not to be had.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options);

  // Shuts down without waiting for jobs. What Shutdown calls left over is waited for.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // The port listened on; 0 without one.
  int port() const;

  // The port of the metrics; 0 without one.
  int metrics_port() const;

  // All metrics, in Prometheus' text format.
  std::string MetricsText() const;

  // Threads that jobs are computed on.
  int threads() const;

  // A channel to this server that needs no port. Usable while the server lives.
  std::shared_ptr<grpc::Channel> InProcessChannel();

  // From now on health says NOT_SERVING and new jobs are refused with SHUTTING_DOWN; what runs goes
  // on. Returns at once.
  void Drain();

  // Drains, waits up to `patience` for the jobs, ends those that are left with SHUTTING_DOWN, and
  // stops. Bounded: patience plus a few seconds. False: all calls have ended, but work of theirs
  // that cannot be interrupted (Draco on a large mesh) is left over on the server's threads; the
  // process may end all the same, by std::_Exit. Further calls return the same.
  bool Shutdown(std::chrono::milliseconds patience);

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace limn
