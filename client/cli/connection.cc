// SPDX-License-Identifier: MIT
// Where a job goes: to a server elsewhere, or to one inside this process.
#include "client/cli/connection.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <CLI/Validators.hpp>

#include "client/servers.h"
#include "engine/base/error.h"
#include "server/limits.h"
#include "server/machine_limits.h"

namespace limn::cli {
namespace {

// A year: longer than any job, and far from the ends of a clock.
constexpr double kLongestDeadline = 365.0 * 24 * 3600;

// Empty if the text names servers. Whether they exist is seen when they are called.
std::string CheckServerAddress(const std::string& text) {
  if (ParseServers(text).ok()) return {};
  return "must be HOST:PORT, such as 127.0.0.1:7410, or numeric ones of one kind with commas "
         "between; got '" +
         text + "'";
}

// Empty if the text is a sensible number of seconds. CLI::Range lets NaN pass.
std::string CheckDeadline(const std::string& text) {
  double seconds = 0;
  if (!CLI::detail::lexical_cast(text, seconds) || !(seconds > 0 && seconds <= kLongestDeadline)) {
    return "must be a number of seconds greater than 0; got '" + text + "'";
  }
  return {};
}

// What gRPC takes as the value of metadata.
bool IsMetadata(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > 0x20 && c < 0x7f; });
}

// One's own machine needs no protection from oneself, except from jobs that cannot fit into it. A
// third of the memory is left to the client's own copy of mesh and answer.
ServerLimits EmbeddedLimits() {
  ServerLimits limits;
  const std::uint64_t memory = MemoryLimit() / 3 * 2;
  for (const LimitEntry& entry : LimitTable()) {
    if (entry.unit == "bytes") {
      limits.*entry.value = std::min(entry.most, memory);
    } else if (entry.unit == "vertices" || entry.unit == "corners" || entry.unit == "refinements") {
      limits.*entry.value = entry.most;
    } else if (entry.unit == "bytes/s") {
      limits.*entry.value = entry.least;
    }
  }
  // What a job of one's own takes, it takes.
  limits.stream_seconds = 0;
  return limits;
}

}  // namespace

CLI::Option* AddServerFlags(CLI::App& app, ConnectionOptions* options) {
  const bool given = !options->server.empty();
  CLI::Option* server =
      app.add_option("--server", options->server,
                     "Server to send the job to; several, as a list or behind a name, take turns"
                     "; without, the job runs inside this process")
          ->check(CLI::Validator(CheckServerAddress, "", "address"))
          ->type_name("HOST:PORT[,HOST:PORT...]");
  if (given) server->description("Server to ask")->capture_default_str();
  const auto add = [&](const char* flag, std::string* value, const char* help) {
    CLI::Option* const option = app.add_option(flag, *value, help);
    return given ? option : option->needs(server);
  };
  const auto add_file = [&](const char* flag, std::string* file, const char* help) {
    add(flag, file, help)->type_name("FILE");
  };
  add_file("--tls-ca", &options->security.ca_file,
           "Speak TLS with it: authorities that its certificate must come from, PEM");
  add_file("--tls-cert", &options->security.certificate_file,
           "Certificate to show it, PEM; needs --tls-key");
  add_file("--tls-key", &options->security.key_file, "The certificate's private key, PEM");
  add_file("--token-file", &options->security.token_file,
           "Bearer token to show it; only sent over TLS or to this machine");
  add("--tls-name", &options->security.server_name,
      "Name that its certificate must be for [the host of --server]")
      ->type_name("NAME");
  app.add_option("--deadline", options->deadline_seconds, "Seconds that it may take")
      ->check(CLI::Validator(CheckDeadline, "", "deadline"))
      ->type_name("S");
  return server;
}

void AddConnectionFlags(CLI::App& app, ConnectionOptions* options) {
  CLI::Option* const server = AddServerFlags(app, options);
  app.add_option("--threads", options->threads,
                 "Threads to compute on, without --server [one per processor]")
      ->check(CLI::Range(1, 1024))
      ->excludes(server)
      ->type_name("N");
}

absl::StatusOr<Connection> Connection::Open(const ConnectionOptions& options) {
  ClientOptions client_options = {.deadline_seconds = options.deadline_seconds.value_or(0)};
  // W3C Trace Context by the environment, as other command lines take it.
  if (const char* trace = std::getenv("TRACEPARENT"); trace != nullptr && IsMetadata(trace)) {
    client_options.metadata.emplace_back("traceparent", trace);
  }
  if (!options.server.empty()) {
    LIMN_ASSIGN_OR_RETURN(
        Client client, Client::ConnectSecurely(options.server, options.security, client_options));
    return Connection(nullptr, std::move(client));
  }
  ServerOptions server_options;
  server_options.threads = options.threads;
  server_options.limits = EmbeddedLimits();
  LIMN_ASSIGN_OR_RETURN(std::unique_ptr<Server> embedded, Server::Start(server_options));
  // It does not go away, and the mesh need not be kept for another attempt.
  client_options.attempts = 1;
  Client client(embedded->InProcessChannel(), client_options);
  return Connection(std::move(embedded), std::move(client));
}

}  // namespace limn::cli
