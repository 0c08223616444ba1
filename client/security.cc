// SPDX-License-Identifier: MIT
#include "client/security.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/servers.h"
#include "engine/base/error.h"
#include "proto/wire/address.h"

namespace limn {
namespace {

constexpr char kSystemAuthorities[] = "/etc/ssl/certs/ca-certificates.crt";

absl::Status Invalid(std::string_view flag, std::string_view message, std::string_view remedy) {
  return MakeError(message, {.reason = Reason::kInvalidOption,
                             .field = std::string(flag),
                             .remedy = std::string(remedy)});
}

absl::StatusOr<std::string> ReadPem(std::string_view flag, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file && text.find("-----BEGIN ") != std::string::npos) return text;
  return Invalid(flag, absl::StrCat(path, file ? " is not PEM" : " cannot be read"),
                 "Name a file in PEM");
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::Channel>> MakeChannel(const std::string& address,
                                                           const ClientSecurity& security,
                                                           bool shared) {
  LIMN_ASSIGN_OR_RETURN(const ServerAddresses servers, ParseServers(address));
  grpc::ChannelArguments arguments;
  SetBalancing(servers, &arguments);
  if (!shared) arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // A proxy from the environment would be asked for this very machine too.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // A server that comes back is found soon, and one that has gone without a word is missed.
  constexpr int kSecond = 1000;
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kSecond / 5);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2 * kSecond);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 60 * kSecond);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 20 * kSecond);
  if (!security.tls()) {
    // A list as a whole is nobody's name.
    arguments.SetString(GRPC_ARG_DEFAULT_AUTHORITY, servers.first);
    return grpc::CreateCustomChannel(servers.target, grpc::InsecureChannelCredentials(), arguments);
  }
  if (security.certificate_file.empty() != security.key_file.empty()) {
    return Invalid(security.key_file.empty() ? "tls-key" : "tls-cert",
                   "a certificate and its key go together", "Give both");
  }
  grpc::SslCredentialsOptions options;
  LIMN_ASSIGN_OR_RETURN(
      options.pem_root_certs,
      ReadPem("tls-ca", security.ca_file.empty() ? kSystemAuthorities : security.ca_file));
  if (!security.certificate_file.empty()) {
    LIMN_ASSIGN_OR_RETURN(options.pem_cert_chain, ReadPem("tls-cert", security.certificate_file));
    LIMN_ASSIGN_OR_RETURN(options.pem_private_key, ReadPem("tls-key", security.key_file));
  }
  if (!security.server_name.empty() || servers.hosts.size() > 1) {
    arguments.SetSslTargetNameOverride(security.server_name.empty() ? servers.hosts[0]
                                                                    : security.server_name);
  }
  return grpc::CreateCustomChannel(servers.target, grpc::SslCredentials(options), arguments);
}

absl::StatusOr<std::string> ReadAuthorization(const std::string& address,
                                              const ClientSecurity& security) {
  if (security.token_file.empty()) return "";
  LIMN_ASSIGN_OR_RETURN(const ServerAddresses servers, ParseServers(address));
  if (!security.tls() &&
      !std::all_of(servers.hosts.begin(), servers.hosts.end(), wire::IsLoopback)) {
    return Invalid("token-file", absl::StrCat("a token would go to ", address, " unencrypted"),
                   "Give --tls-ca too");
  }
  std::ifstream file(security.token_file);
  if (!file) {
    return Invalid("token-file", absl::StrCat(security.token_file, " cannot be read"),
                   "Name a file that holds a token");
  }
  for (std::string line; std::getline(file, line);) {
    const std::vector<std::string> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty() || words[0][0] == '#') continue;
    // gRPC would end the process's call with less of an explanation.
    const bool visible = std::all_of(words.back().begin(), words.back().end(), [](char c) {
      return absl::ascii_isgraph(static_cast<unsigned char>(c));
    });
    if (visible) return absl::StrCat("Bearer ", words.back());
    break;
  }
  return Invalid("token-file", absl::StrCat(security.token_file, " holds no token"),
                 "Write it in one line of visible ASCII characters");
}

}  // namespace limn
