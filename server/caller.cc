// SPDX-License-Identifier: MIT
#include "server/caller.h"

#include <grpcpp/security/auth_context.h>

#include <algorithm>
#include <optional>
#include <random>

#include "absl/strings/ascii.h"
#include "absl/strings/str_format.h"
#include "engine/base/error.h"

namespace limn {
namespace {

constexpr std::size_t kMostRequestId = 128;

std::string MakeRequestId() {
  thread_local std::mt19937_64 random{std::random_device{}()};
  return absl::StrFormat("%016x", random());
}

// The only value of that name; nothing when there are several.
std::optional<std::string_view> OnlyValue(const grpc::CallbackServerContext& context,
                                          const char* name) {
  const auto [begin, end] = context.client_metadata().equal_range(name);
  if (begin == end || std::next(begin) != end) return std::nullopt;
  return std::string_view(begin->second.data(), begin->second.size());
}

bool IsLowerHex(std::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

bool IsZero(std::string_view text) { return text.find_first_not_of('0') == std::string_view::npos; }

// "ipv4:127.0.0.1:5000" -> "ipv4:127.0.0.1": connections come and go, hosts stay.
std::string HostOf(const std::string& peer) {
  const std::size_t colon = peer.rfind(':');
  return colon == std::string::npos || colon == peer.find(':') ? peer : peer.substr(0, colon);
}

std::string CertificateName(const grpc::CallbackServerContext& context) {
  const auto auth = context.auth_context();
  if (auth == nullptr || !auth->IsPeerAuthenticated()) return "";
  const auto identity = auth->GetPeerIdentity();
  return identity.empty() ? "" : std::string(identity.front().data(), identity.front().size());
}

}  // namespace

TraceParent ParseTraceParent(std::string_view text) {
  // version "-" trace-id "-" parent-id "-" trace-flags
  constexpr std::size_t kLength = 55;
  if (text.size() < kLength || text[2] != '-' || text[35] != '-' || text[52] != '-') return {};
  const std::string_view version = text.substr(0, 2);
  const std::string_view trace_id = text.substr(3, 32);
  const std::string_view parent_id = text.substr(36, 16);
  if (!IsLowerHex(version) || version == "ff" || !IsLowerHex(text.substr(53, 2))) return {};
  if (version == "00" ? text.size() != kLength : text.size() > kLength && text[kLength] != '-') {
    return {};
  }
  if (!IsLowerHex(trace_id) || IsZero(trace_id) || !IsLowerHex(parent_id) || IsZero(parent_id)) {
    return {};
  }
  return {std::string(trace_id), std::string(parent_id)};
}

bool IsRequestId(std::string_view text) {
  return !text.empty() && text.size() <= kMostRequestId &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return absl::ascii_isgraph(static_cast<unsigned char>(c)); });
}

Caller IdentifyCaller(const grpc::CallbackServerContext& context, const Tokens* tokens) {
  Caller caller;
  const std::string_view request_id = OnlyValue(context, kRequestIdKey).value_or("");
  caller.request_id = IsRequestId(request_id) ? std::string(request_id) : MakeRequestId();
  caller.trace = ParseTraceParent(OnlyValue(context, "traceparent").value_or(""));
  caller.peer = context.peer();
  caller.client = CertificateName(context);
  if (caller.client.empty()) caller.client = HostOf(caller.peer);
  if (tokens == nullptr) return caller;
  const std::optional<std::string_view> authorization = OnlyValue(context, "authorization");
  const std::optional<std::string> name =
      authorization.has_value() ? tokens->ClientOf(*authorization) : std::nullopt;
  if (name.has_value()) {
    caller.client = *name;
  } else {
    caller.authorized =
        MakeError(authorization.has_value() ? "the token is not one of this server's"
                                            : "this server asks for a token and the call has none",
                  {.reason = Reason::kUnauthenticated,
                   .field = "authorization",
                   .remedy = "Send the metadata \"authorization: Bearer TOKEN\""});
  }
  return caller;
}

}  // namespace limn
