// SPDX-License-Identifier: MIT
#include "server/tls.h"

#include <grpcpp/security/server_credentials.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <cstdio>
#include <ctime>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr unsigned kReloadSeconds = 1;

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
template <class T>
using Owned = std::unique_ptr<T, Closer>;

absl::Status Invalid(std::string_view flag, std::string_view message, std::string_view remedy) {
  return MakeError(message, {.reason = Reason::kInvalidOption,
                             .field = std::string(flag),
                             .remedy = std::string(remedy)});
}

// Without asking anybody for a passphrase.
int NoPassphrase(char* /*buffer*/, int /*size*/, int /*writing*/, void* /*data*/) { return 0; }

absl::StatusOr<Owned<X509>> ReadCertificate(const std::string& flag, const std::string& path) {
  const Owned<std::FILE> file(std::fopen(path.c_str(), "re"));
  Owned<X509> certificate(
      file == nullptr ? nullptr : PEM_read_X509(file.get(), nullptr, NoPassphrase, nullptr));
  if (certificate != nullptr) return certificate;
  return Invalid(flag,
                 absl::StrCat(path, file == nullptr ? " cannot be read" : " is no certificate"),
                 "Name a certificate in PEM");
}

absl::StatusOr<Owned<EVP_PKEY>> ReadKey(const std::string& path) {
  const Owned<std::FILE> file(std::fopen(path.c_str(), "re"));
  Owned<EVP_PKEY> key(
      file == nullptr ? nullptr : PEM_read_PrivateKey(file.get(), nullptr, NoPassphrase, nullptr));
  if (key != nullptr) return key;
  return Invalid("tls-key",
                 absl::StrCat(path, file == nullptr ? " cannot be read" : " is no private key"),
                 "Name an unencrypted private key in PEM");
}

}  // namespace

absl::Status CheckTlsFiles(const TlsFiles& files) {
  if (files.certificate.empty()) {
    if (!files.key.empty()) return Invalid("tls-key", "there is no --tls-cert", "Give both");
    if (!files.client_authorities.empty()) {
      return Invalid("tls-client-ca", "there is no --tls-cert",
                     "Clients' certificates need the server's");
    }
    return absl::OkStatus();
  }
  if (files.key.empty()) return Invalid("tls-key", "--tls-cert needs its key", "Give --tls-key");
  LIMN_ASSIGN_OR_RETURN(const Owned<X509> certificate,
                        ReadCertificate("tls-cert", files.certificate));
  LIMN_ASSIGN_OR_RETURN(const Owned<EVP_PKEY> key, ReadKey(files.key));
  if (X509_check_private_key(certificate.get(), key.get()) != 1) {
    return Invalid("tls-key", absl::StrCat(files.key, " is not the key of ", files.certificate),
                   "Give the key that the certificate was made for");
  }
  if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0) {
    return Invalid("tls-cert", absl::StrCat(files.certificate, " has expired"), "Renew it");
  }
  if (files.client_authorities.empty()) return absl::OkStatus();
  return ReadCertificate("tls-client-ca", files.client_authorities).status();
}

std::shared_ptr<grpc::ServerCredentials> MakeTlsCredentials(const TlsFiles& files) {
  namespace tls = grpc::experimental;
  tls::TlsServerCredentialsOptions options(std::make_shared<tls::FileWatcherCertificateProvider>(
      files.key, files.certificate, files.client_authorities, kReloadSeconds));
  options.watch_identity_key_cert_pairs();
  if (!files.client_authorities.empty()) {
    options.watch_root_certs();
    options.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  } else {
    options.set_cert_request_type(GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  }
  return tls::TlsServerCredentials(options);
}

absl::StatusOr<std::int64_t> CertificateExpiry(const std::string& path) {
  LIMN_ASSIGN_OR_RETURN(const Owned<X509> certificate, ReadCertificate("tls-cert", path));
  std::tm until{};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &until) != 1) {
    return Invalid("tls-cert", absl::StrCat(path, " has no date of expiry"), "Renew it");
  }
  return static_cast<std::int64_t>(timegm(&until));
}

}  // namespace limn
