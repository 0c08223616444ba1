// SPDX-License-Identifier: MIT
// How a client proves itself to a server, and the server to it.
#pragma once

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace grpc {
class Channel;
}

namespace limn {

// Files in PEM, but for the token. Any of the three first has TLS spoken.
struct ClientSecurity {
  // Authorities that the server's certificate must come from. Empty: those of the system.
  std::string ca_file;
  // This client's certificate, followed by the intermediate ones, and its private key; both or
  // neither.
  std::string certificate_file;
  std::string key_file;
  // The name that the server's certificate must be for. Empty: the host, of several the first.
  std::string server_name;
  // A bearer token: the last word of the first line that is neither empty nor begins with '#', so
  // that a server's file of tokens does too. Empty: none is sent. Without TLS it is only taken for
  // this very machine's addresses: anybody on the way could read it.
  std::string token_file;

  bool tls() const { return !ca_file.empty() || !certificate_file.empty() || !key_file.empty(); }
};

// A channel to a server; it connects when the first call needs it. address: one or several, as
// ParseServers has them, and balanced as SetBalancing says. Errors: INVALID_OPTION naming "server",
// "tls-ca", "tls-cert", "tls-key" or "token-file". shared: with other channels of the same kind;
// else its connection is its own.
[[nodiscard]] absl::StatusOr<std::shared_ptr<grpc::Channel>> MakeChannel(
    const std::string& address, const ClientSecurity& security, bool shared = true);

// The value of the metadata "authorization" that a token file stands for; empty without one.
// Errors: as above.
[[nodiscard]] absl::StatusOr<std::string> ReadAuthorization(const std::string& address,
                                                            const ClientSecurity& security);

}  // namespace limn
