// SPDX-License-Identifier: MIT
// Where a job goes: to a server elsewhere, or to one inside this process.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "absl/status/statusor.h"
#include "client/client.h"
#include "server/server.h"

namespace limn::cli {

struct ConnectionOptions {
  // As ParseServers of client/servers.h has it; empty for the embedded server.
  std::string server;
  // Threads of the embedded server; 0 is one per processor.
  int threads = 0;
  // Seconds that a job may take. Absent: any time.
  std::optional<double> deadline_seconds;
  ClientSecurity security;
};

// Adds --server, what goes with it, and --deadline. Returns --server.
CLI::Option* AddServerFlags(CLI::App& app, ConnectionOptions* options);
// The same with --threads, for what may also run inside this process.
void AddConnectionFlags(CLI::App& app, ConnectionOptions* options);

// A client and, when it is embedded, the server behind it: the same service, over a channel inside
// the process instead of a port.
class Connection {
 public:
  // Errors: those of Server::Start and of Client::ConnectSecurely. A server elsewhere is not looked
  // for before the first job.
  [[nodiscard]] static absl::StatusOr<Connection> Open(const ConnectionOptions& options);

  const Client& client() const { return client_; }

 private:
  Connection(std::unique_ptr<Server> embedded, Client client)
      : embedded_(std::move(embedded)), client_(std::move(client)) {}

  // Before the client, which has to go first.
  std::unique_ptr<Server> embedded_;
  Client client_;
};

}  // namespace limn::cli
