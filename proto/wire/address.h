// SPDX-License-Identifier: MIT
// HOST:PORT, and whether that is this machine only.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace limn::wire {

struct HostPort {
  // Without brackets.
  std::string host;
  int port = 0;
};

// HOST:PORT with a port of 0 to 65,535 and IPv6 hosts in brackets; nothing for any other text.
// Names are not resolved.
[[nodiscard]] std::optional<HostPort> ParseHostPort(std::string_view address);

// Whether the host is certainly this machine: 127.0.0.0/8, ::1, localhost.
[[nodiscard]] bool IsLoopback(const std::string& host);

}  // namespace limn::wire
