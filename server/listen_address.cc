// SPDX-License-Identifier: MIT
#include "server/listen_address.h"

#include <optional>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/address.h"

namespace limn {

absl::Status CheckListenAddress(const std::string& address, bool anywhere,
                                const std::string& flag) {
  const auto invalid = [&](const std::string& message, std::string_view remedy) {
    return MakeError(
        absl::StrCat("\"", absl::Utf8SafeCHexEscape(address), "\" ", message),
        {.reason = Reason::kInvalidOption, .field = flag, .remedy = std::string(remedy)});
  };
  const std::optional<wire::HostPort> parsed = wire::ParseHostPort(address);
  if (!parsed.has_value()) {
    return invalid("is not HOST:PORT",
                   "Use an address such as 127.0.0.1:7410, and brackets for an IPv6 host");
  }
  if (anywhere || wire::IsLoopback(parsed->host)) return absl::OkStatus();
  return invalid("may be reached from other machines, and nothing would be encrypted",
                 flag == "listen" ? "Listen on 127.0.0.1, give --tls-cert, or say --insecure"
                                  : "Listen on 127.0.0.1, or say --insecure");
}

}  // namespace limn
