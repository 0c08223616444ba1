// SPDX-License-Identifier: MIT
#include "server/listen_address.h"

#include <arpa/inet.h>

#include <string>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr int kMostPort = 65'535;

absl::Status Invalid(std::string_view message, std::string_view remedy) {
  return MakeError(
      message,
      {.reason = Reason::kInvalidOption, .field = "listen", .remedy = std::string(remedy)});
}

bool IsLoopback(const std::string& host) {
  if (host == "localhost") return true;
  if (in_addr v4{}; inet_pton(AF_INET, host.c_str(), &v4) == 1) {
    return (ntohl(v4.s_addr) >> 24) == 127;
  }
  in6_addr v6{};
  return inet_pton(AF_INET6, host.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

}  // namespace

absl::Status CheckListenAddress(const std::string& address, bool anywhere) {
  const std::string shown = absl::Utf8SafeCHexEscape(address);
  const std::size_t colon = address.rfind(':');
  int port = -1;
  if (colon == std::string::npos || colon == 0 ||
      !absl::SimpleAtoi(address.substr(colon + 1), &port) || port < 0 || port > kMostPort) {
    return Invalid(absl::StrCat("\"", shown, "\" is not HOST:PORT"),
                   "Use an address such as 127.0.0.1:7410");
  }
  std::string host = address.substr(0, colon);
  if (host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string::npos) {
    return Invalid(absl::StrCat("\"", shown, "\" is not HOST:PORT"),
                   "Put an IPv6 host in brackets");
  }
  if (anywhere || IsLoopback(host)) return absl::OkStatus();
  return Invalid(absl::StrCat("\"", shown, "\" may be reached from other machines, and the ",
                              "connection is neither encrypted nor authenticated"),
                 "Listen on 127.0.0.1, or say --insecure");
}

}  // namespace limn
