// SPDX-License-Identifier: MIT
// `limn health`: whether a server serves, for probes of containers and for people.
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/App.hpp>

#include "client/cli/commands.h"
#include "client/cli/connection.h"

namespace limn::cli {
namespace {

struct HealthFlags {
  std::string service;
  ConnectionOptions connection;
};

ExitStatus Run(const HealthFlags& flags) {
  const absl::StatusOr<Connection> connection = Connection::Open(flags.connection);
  if (!connection.ok()) return FailWithJob(connection.status());
  const absl::StatusOr<bool> serves = connection->client().Serves(flags.service);
  if (!serves.ok()) {
    PrintError("no answer from " + flags.connection.server + " (" +
               std::string(serves.status().message()) + ")");
    return ExitStatus::kServer;
  }
  std::puts(*serves ? "SERVING" : "NOT_SERVING");
  return *serves ? ExitStatus::kOk : ExitStatus::kServer;
}

}  // namespace

void AddHealthCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command =
      app.add_subcommand("health", "Ask a server whether it serves (grpc.health.v1)");
  const auto flags = std::make_shared<HealthFlags>();
  flags->connection.server = "127.0.0.1:7410";
  flags->connection.deadline_seconds = 5;
  command
      ->add_option("--service", flags->service,
                   "\"\" and \"limn.v1.LimnService\": ready for jobs; \"liveness\": not stuck")
      ->type_name("NAME");
  AddServerFlags(*command, &flags->connection);
  // For the health check of a container image, which is the same whatever the server's flags are.
  for (const auto& [flag, variable] :
       {std::pair("--server", "LIMN_HEALTH_SERVER"), std::pair("--tls-ca", "LIMN_HEALTH_TLS_CA"),
        std::pair("--tls-cert", "LIMN_HEALTH_TLS_CERT"),
        std::pair("--tls-key", "LIMN_HEALTH_TLS_KEY"),
        std::pair("--tls-name", "LIMN_HEALTH_TLS_NAME")}) {
    command->get_option(flag)->envname(variable);
  }
  command->footer("Exit status 0 if it serves, 3 if not or if it does not answer.");
  command->callback([flags, status] { *status = Run(*flags); });
}

}  // namespace limn::cli
