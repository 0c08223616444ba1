// SPDX-License-Identifier: MIT
// See address.h.
#include "proto/wire/address.h"

#include <arpa/inet.h>

#include "absl/strings/numbers.h"

namespace limn::wire {
namespace {

constexpr int kMostPort = 65'535;

}  // namespace

std::optional<HostPort> ParseHostPort(std::string_view address) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  HostPort parsed;
  const std::string port(address.substr(colon + 1));
  if (!absl::SimpleAtoi(port, &parsed.port) || parsed.port < 0 || parsed.port > kMostPort) {
    return std::nullopt;
  }
  std::string_view host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return std::nullopt;
  }
  parsed.host = std::string(host);
  return parsed;
}

bool IsLoopback(const std::string& host) {
  if (host == "localhost") return true;
  if (in_addr v4{}; inet_pton(AF_INET, host.c_str(), &v4) == 1) {
    return (ntohl(v4.s_addr) >> 24) == 127;
  }
  in6_addr v6{};
  return inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

}  // namespace limn::wire
