// SPDX-License-Identifier: MIT
// TLS and mutual TLS of the listening port, with certificates that are read again when they change.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <ctime>
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

// The certificates of a server. Thread-compatible.
class TlsIdentity {
 public:
  // files: with a certificate. Errors: those of CheckTlsFiles.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<TlsIdentity>> Load(const TlsFiles& files);
  ~TlsIdentity();
  TlsIdentity(const TlsIdentity&) = delete;
  TlsIdentity& operator=(const TlsIdentity&) = delete;

  // For listening ports. They need this object.
  [[nodiscard]] std::shared_ptr<grpc::ServerCredentials> Credentials() const;

  // Reads the files again if they have changed; connections made from a second later on see them.
  // After an error, those of CheckTlsFiles, what held holds on. True: there is something new.
  [[nodiscard]] absl::StatusOr<bool> Refresh();

  // When the server's certificate expires, in seconds since 1970.
  std::int64_t expiry() const { return expiry_; }

 private:
  static constexpr std::size_t kFiles = 3;
  explicit TlsIdentity(const TlsFiles& files);
  [[nodiscard]] std::array<timespec, kFiles> Modified() const;
  [[nodiscard]] absl::Status Take();

  const TlsFiles files_;
  // What gRPC reads: files in memory that hold what has been found to fit together. Their
  // descriptors stay, what is behind them is exchanged.
  std::array<int, kFiles> copies_{-1, -1, -1};
  std::array<timespec, kFiles> modified_{};
  std::int64_t expiry_ = 0;
};

}  // namespace limn
