// SPDX-License-Identifier: MIT
#include "tests/server/certificates.h"

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <stdlib.h>

#include <fstream>
#include <stdexcept>

namespace limn {
namespace {

struct Freer {
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  void operator()(X509* certificate) const { X509_free(certificate); }
  void operator()(BIO* bio) const { BIO_free(bio); }
};
using Key = std::unique_ptr<EVP_PKEY, Freer>;
using Certificate = std::unique_ptr<X509, Freer>;

template <class Write>
std::string Pem(const Write& write) {
  const std::unique_ptr<BIO, Freer> bio(BIO_new(BIO_s_mem()));
  write(bio.get());
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &bytes);
  return {bytes, static_cast<std::size_t>(size)};
}

void AddExtension(X509* certificate, X509* issuer, int nid, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, nid, value);
  if (extension == nullptr) throw std::runtime_error(value);
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

// issuer, signer: null for a certificate that signs itself.
Certificate Make(const std::string& name, EVP_PKEY* key, long valid_seconds, X509* issuer,
                 EVP_PKEY* signer) {
  static long serial = 0;
  Certificate made(X509_new());
  X509_set_version(made.get(), 2);
  ASN1_INTEGER_set(X509_get_serialNumber(made.get()), ++serial);
  X509_gmtime_adj(X509_getm_notBefore(made.get()), -7200);
  X509_gmtime_adj(X509_getm_notAfter(made.get()), valid_seconds);
  X509_set_pubkey(made.get(), key);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(made.get()), "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509* const from = issuer != nullptr ? issuer : made.get();
  X509_set_issuer_name(made.get(), X509_get_subject_name(from));
  if (issuer == nullptr) {
    AddExtension(made.get(), from, NID_basic_constraints, "critical,CA:TRUE");
    AddExtension(made.get(), from, NID_key_usage, "critical,keyCertSign,cRLSign");
  } else {
    const std::string names = "DNS:" + name + ",DNS:localhost,IP:127.0.0.1";
    AddExtension(made.get(), from, NID_subject_alt_name, names.c_str());
  }
  X509_sign(made.get(), signer != nullptr ? signer : key, EVP_sha256());
  return made;
}

}  // namespace

struct TestAuthority::Impl {
  Key key;
  Certificate certificate;
};

TestAuthority::TestAuthority(const std::string& name)
    : impl_(std::make_unique<Impl>(Impl{Key(EVP_EC_gen("P-256")), nullptr})) {
  impl_->certificate = Make(name, impl_->key.get(), 86'400, nullptr, nullptr);
  pem_ = Pem([&](BIO* bio) { PEM_write_bio_X509(bio, impl_->certificate.get()); });
}

TestAuthority::~TestAuthority() = default;

TestIdentity TestAuthority::Issue(const std::string& name, long valid_seconds) const {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate made =
      Make(name, key.get(), valid_seconds, impl_->certificate.get(), impl_->key.get());
  return {Pem([&](BIO* bio) { PEM_write_bio_X509(bio, made.get()); }), Pem([&](BIO* bio) {
            PEM_write_bio_PKCS8PrivateKey(bio, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
          })};
}

TestDirectory::TestDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "limn_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no directory " + name);
  root_ = name;
}

TestDirectory::~TestDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(root_, ignored);
}

std::string TestDirectory::Write(const std::string& name, const std::string& text) const {
  const std::string temporary = path(name + ".new");
  std::ofstream(temporary, std::ios::binary) << text;
  std::filesystem::rename(temporary, path(name));
  return path(name);
}

}  // namespace limn
