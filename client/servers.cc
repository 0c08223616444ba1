// SPDX-License-Identifier: MIT
#include "client/servers.h"

#include <arpa/inet.h>
#include <grpc/grpc.h>

#include <algorithm>
#include <optional>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "engine/base/error.h"
#include "proto/wire/address.h"

namespace limn {
namespace {

// gRPC retries what it has kept of a call; 256 KiB of it by default, which is no mesh.
constexpr int kRetryBytes = 4 << 20;
constexpr int kSecond = 1000;

// Asked of each connection, so that calls go around a server that drains. Of several only: one that
// drains had better say so itself.
constexpr char kHealthConfig[] = R"json({
  "healthCheckConfig": {"serviceName": "limn.v1.LimnService"},)json";
// The policy is for calls that no server has begun to answer.
constexpr char kServiceConfig[] = R"json(
  "loadBalancingConfig": [{"round_robin": {}}],
  "methodConfig": [{
    "name": [{"service": "limn.v1.LimnService"}],
    "retryPolicy": {
      "maxAttempts": 3,
      "initialBackoff": "0.05s",
      "maxBackoff": "1s",
      "backoffMultiplier": 2,
      "retryableStatusCodes": ["UNAVAILABLE"]
    }
  }]
})json";

absl::Status Invalid(std::string_view text, std::string_view remedy) {
  return MakeError(
      absl::StrCat("'", std::string(text), "' is no address of servers"),
      {.reason = Reason::kInvalidOption, .field = "server", .remedy = std::string(remedy)});
}

// 4, 6, or 0 for a name.
int Version(const std::string& host) {
  in_addr v4{};
  in6_addr v6{};
  if (inet_pton(AF_INET, host.c_str(), &v4) == 1) return 4;
  return inet_pton(AF_INET6, host.c_str(), &v6) == 1 ? 6 : 0;
}

}  // namespace

absl::StatusOr<ServerAddresses> ParseServers(std::string_view text) {
  std::string rest(text);
  for (const std::string_view scheme : {"dns:///", "ipv4:", "ipv6:"}) {
    if (!text.starts_with(scheme)) continue;
    rest.erase(0, scheme.size());
    break;
  }
  std::vector<std::string> entries = absl::StrSplit(rest, ',');
  ServerAddresses servers{.target = "", .first = entries[0], .hosts = {}};
  int version = 0;
  for (const std::string& entry : entries) {
    const std::optional<wire::HostPort> parsed = wire::ParseHostPort(entry);
    if (!parsed.has_value() || parsed->port < 1) {
      return Invalid(text, "Give HOST:PORT, such as 127.0.0.1:7410");
    }
    const int kind = Version(parsed->host);
    if (servers.hosts.empty()) version = kind;
    if (kind != version || (entries.size() > 1 && kind == 0)) {
      return Invalid(text,
                     "A list takes numeric addresses of one kind; several servers may also "
                     "stand behind one name");
    }
    servers.hosts.push_back(parsed->host);
  }
  std::shuffle(entries.begin(), entries.end(), std::minstd_rand(std::random_device{}()));
  servers.target = entries.size() == 1 ? absl::StrCat("dns:///", rest)
                                       : absl::StrCat(version == 4 ? "ipv4:" : "ipv6:",
                                                      absl::StrJoin(entries, ","));
  return servers;
}

bool IsOneServer(const ServerAddresses& servers) {
  const std::string& host = servers.hosts[0];
  return servers.hosts.size() == 1 && (Version(host) != 0 || host == "localhost");
}

void SetBalancing(const ServerAddresses& servers, grpc::ChannelArguments* arguments) {
  arguments->SetServiceConfigJSON(
      absl::StrCat(IsOneServer(servers) ? "{" : kHealthConfig, kServiceConfig));
  // The policy is this one, whatever TXT records say.
  arguments->SetInt(GRPC_ARG_SERVICE_CONFIG_DISABLE_RESOLUTION, 1);
  arguments->SetInt(GRPC_ARG_PER_RPC_RETRY_BUFFER_SIZE, kRetryBytes);
  arguments->SetInt(GRPC_ARG_DNS_MIN_TIME_BETWEEN_RESOLUTIONS_MS, kSecond);
  arguments->SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kSecond / 5);
  arguments->SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 5 * kSecond);
  arguments->SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kSecond);
  // The question after its health keeps a connection from being idle for the server, so that it is
  // for the client to end.
  arguments->SetInt(GRPC_ARG_CLIENT_IDLE_TIMEOUT_MS, 300 * kSecond);
  arguments->SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 20 * kSecond);
  arguments->SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10 * kSecond);
}

}  // namespace limn
