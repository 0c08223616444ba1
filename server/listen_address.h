// SPDX-License-Identifier: MIT
// Addresses to listen on.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace limn {

// Ok for HOST:PORT with a host that is certainly this machine only (127.0.0.0/8, ::1, localhost)
// or, when `anywhere`, with any host; IPv6 hosts in brackets; port 0 means a free one. Names are
// not resolved. Errors: INVALID_OPTION naming `flag`.
[[nodiscard]] absl::Status CheckListenAddress(const std::string& address, bool anywhere,
                                              const std::string& flag = "listen");

}  // namespace limn
