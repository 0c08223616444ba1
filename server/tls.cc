// SPDX-License-Identifier: MIT
#include "server/tls.h"

#include <fcntl.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "absl/cleanup/cleanup.h"
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

// In seconds since 1970.
absl::StatusOr<std::int64_t> CertificateExpiry(const std::string& path) {
  LIMN_ASSIGN_OR_RETURN(const Owned<X509> certificate, ReadCertificate("tls-cert", path));
  std::tm until{};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate.get()), &until) != 1) {
    return Invalid("tls-cert", absl::StrCat(path, " has no date of expiry"), "Renew it");
  }
  return static_cast<std::int64_t>(timegm(&until));
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

TlsIdentity::TlsIdentity(const TlsFiles& files) : files_(files) {
  for (int& copy : copies_) copy = memfd_create("limnd-tls", MFD_CLOEXEC);
}

TlsIdentity::~TlsIdentity() {
  for (const int copy : copies_) close(copy);
}

absl::StatusOr<std::unique_ptr<TlsIdentity>> TlsIdentity::Load(const TlsFiles& files) {
  std::unique_ptr<TlsIdentity> identity(new TlsIdentity(files));
  identity->modified_ = identity->Modified();
  LIMN_RETURN_IF_ERROR(identity->Take());
  return identity;
}

std::shared_ptr<grpc::ServerCredentials> TlsIdentity::Credentials() const {
  namespace tls = grpc::experimental;
  const bool mutual = !files_.client_authorities.empty();
  const auto path = [&](std::size_t file) { return absl::StrCat("/proc/self/fd/", copies_[file]); };
  tls::TlsServerCredentialsOptions options(std::make_shared<tls::FileWatcherCertificateProvider>(
      path(1), path(0), mutual ? path(2) : std::string(), kReloadSeconds));
  options.watch_identity_key_cert_pairs();
  if (mutual) options.watch_root_certs();
  options.set_cert_request_type(mutual ? GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY
                                       : GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE);
  return tls::TlsServerCredentials(options);
}

absl::StatusOr<bool> TlsIdentity::Refresh() {
  const std::array<timespec, kFiles> modified = Modified();
  const bool same =
      std::equal(modified.begin(), modified.end(), modified_.begin(),
                 [](auto& a, auto& b) { return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec; });
  if (same) return false;
  // Also after a failure: it is reported once.
  modified_ = modified;
  LIMN_RETURN_IF_ERROR(Take());
  return true;
}

std::array<timespec, TlsIdentity::kFiles> TlsIdentity::Modified() const {
  std::array<timespec, kFiles> modified{};
  const std::array paths = {&files_.certificate, &files_.key, &files_.client_authorities};
  for (std::size_t i = 0; i < kFiles; ++i) {
    struct stat status {};
    if (!paths[i]->empty() && stat(paths[i]->c_str(), &status) == 0) modified[i] = status.st_mtim;
  }
  return modified;
}

absl::Status TlsIdentity::Take() {
  // Copied first and checked then, so that what is checked is what is used.
  std::array<int, kFiles> copies{};
  const std::array paths = {&files_.certificate, &files_.key, &files_.client_authorities};
  const absl::Cleanup close_all = [&copies] {
    for (const int copy : copies) close(copy);
  };
  TlsFiles copied;
  const std::array names = {&copied.certificate, &copied.key, &copied.client_authorities};
  for (std::size_t i = 0; i < kFiles; ++i) {
    copies[i] = memfd_create("limnd-tls", MFD_CLOEXEC);
    if (paths[i]->empty()) continue;
    std::ifstream file(*paths[i], std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file || write(copies[i], text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
      // Names the file that cannot be read.
      return CheckTlsFiles(files_);
    }
    *names[i] = absl::StrCat("/proc/self/fd/", copies[i]);
  }
  if (!CheckTlsFiles(copied).ok()) {
    LIMN_RETURN_IF_ERROR(CheckTlsFiles(files_));
    return Invalid("tls-cert", "the files change", "Wait");
  }
  LIMN_ASSIGN_OR_RETURN(expiry_, CertificateExpiry(copied.certificate));
  for (std::size_t i = 0; i < kFiles; ++i) dup3(copies[i], copies_[i], O_CLOEXEC);
  return absl::OkStatus();
}

}  // namespace limn
