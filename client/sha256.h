// SPDX-License-Identifier: MIT
// SHA-256 (FIPS 180-4), by OpenSSL.
#pragma once

#include <google/protobuf/message_lite.h>

#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace limn {

// Not thread-safe. Throws std::bad_alloc when OpenSSL cannot.
class Sha256 {
 public:
  Sha256();
  Sha256& Add(std::string_view bytes);
  // The 32 bytes of all that was added. Once.
  [[nodiscard]] std::string Finish();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

// The message's bytes, the same for the same content within one version of the library.
[[nodiscard]] std::string DeterministicBytes(const google::protobuf::MessageLite& message);

}  // namespace limn
