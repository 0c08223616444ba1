// SPDX-License-Identifier: MIT
// TLS and mutual TLS of the listening port, with certificates that are read again when they change.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace grpc {
class ServerCredentials;
}

namespace limn {

// PEM files.
struct TlsFiles {
  // The server's certificate, followed by the intermediate ones. Empty: no TLS.
  std::string certificate;
  // Its private key.
  std::string key;
  // Certificates of the authorities that clients' certificates must come from. Empty: clients need
  // none.
  std::string client_authorities;
};

// Whether the flags make sense together, and the files as they are now: readable, the key that of
// the certificate, the certificate not expired. Errors: INVALID_OPTION naming the flag.
[[nodiscard]] absl::Status CheckTlsFiles(const TlsFiles& files);

// Credentials for a listening port. Files that change count for connections that are made from a
// second later on; what does not fit together is not taken over. files: checked, with a
// certificate.
[[nodiscard]] std::shared_ptr<grpc::ServerCredentials> MakeTlsCredentials(const TlsFiles& files);

// When the first certificate of the file expires, in seconds since 1970. Errors: as CheckTlsFiles,
// naming "tls-cert".
[[nodiscard]] absl::StatusOr<std::int64_t> CertificateExpiry(const std::string& path);

}  // namespace limn
