// SPDX-License-Identifier: MIT
// Who makes a call, and what it is called in logs: from the call's metadata.
//
//   authorization   "Bearer TOKEN", where the server asks for tokens
//   x-request-id    the call's name, 1 to 128 visible ASCII characters; anything else is replaced
//   traceparent     W3C Trace Context, version 00; anything else is left out
#pragma once

#include <grpcpp/server_context.h>

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "server/tokens.h"

namespace limn {

// The metadata in which a call's name comes and goes back.
inline constexpr char kRequestIdKey[] = "x-request-id";

// The ids of a traceparent header.
struct TraceParent {
  // 32 hexadecimal digits; empty when there is none.
  std::string trace_id;
  // 16 hexadecimal digits: the client's span.
  std::string parent_id;
};

// https://www.w3.org/TR/trace-context, section 3.2. Nothing for text that is not well-formed.
// Versions above 00 are read as far as 00 goes, as the text asks for.
[[nodiscard]] TraceParent ParseTraceParent(std::string_view text);

// Whether the text may be a call's name.
[[nodiscard]] bool IsRequestId(std::string_view text);

struct Caller {
  std::string request_id;
  TraceParent trace;
  // Where it calls from, as gRPC says it, such as "ipv4:127.0.0.1:5000".
  std::string peer;
  // Who it is, for fair shares and logs: the name of its token, else its certificate's, else the
  // host that it calls from.
  std::string client;
  // Ok, or UNAUTHENTICATED.
  absl::Status authorized;
};

// tokens: null when none are asked for. Thread-safe.
[[nodiscard]] Caller IdentifyCaller(const grpc::CallbackServerContext& context,
                                    const Tokens* tokens);

}  // namespace limn
