// SPDX-License-Identifier: MIT
// Where servers are, and how calls are spread over several of them without a proxy between.
#pragma once

#include <grpcpp/support/channel_arguments.h>

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace limn {

// One server, the servers behind one name, or a list of them.
struct ServerAddresses {
  // What gRPC resolves, again and again: "dns:///HOST:PORT", "ipv4:A:PORT,B:PORT" or "ipv6:...". A
  // list is in an order of chance, so that many clients of few calls do not all begin with the
  // first.
  std::string target;
  // "HOST:PORT" of the first that was named.
  std::string first;
  // Every host as it was named, without brackets.
  std::vector<std::string> hosts;
};

// text: "HOST:PORT", where the host may be a name with several addresses (with or without
// "dns:///" before it), or a list "A:PORT,B:PORT" of numeric addresses that are all IPv4 or all
// IPv6 in brackets (with or without "ipv4:" or "ipv6:" before it). Ports from 1 to 65,535. Errors:
// INVALID_OPTION in the field "server". Thread-safe.
[[nodiscard]] absl::StatusOr<ServerAddresses> ParseServers(std::string_view text);

// Whether the text can only be one server: one numeric address, or localhost.
[[nodiscard]] bool IsOneServer(const ServerAddresses& servers);

// Has a channel send each call to the next of its servers that is connected and, unless there is
// only one, says of itself that it serves (grpc.health.v1, which a draining server does not). It
// sends a call again, three times in all, where UNAVAILABLE came before anything of an answer,
// looks up names anew when a connection ends, tries lost servers every second, and notices within
// 30 seconds that the other side of a running call is gone without a word.
void SetBalancing(const ServerAddresses& servers, grpc::ChannelArguments* arguments);

}  // namespace limn
