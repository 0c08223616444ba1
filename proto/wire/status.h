// SPDX-License-Identifier: MIT
// The one map between errors of the engine and gRPC status. Details travel as google.rpc.Status in
// the trailer "grpc-status-details-bin": ErrorInfo with every error, BadRequest for bad input,
// RetryInfo for what is retryable, and for UNAVAILABLE.
//
// ErrorInfo.metadata holds "field", "index" and "remedy" where the error has them, and "limit" with
// LIMIT_EXCEEDED: the name of the limit, or the field again where the limit cannot be set. The path
// in BadRequest is the field with its index behind it, "faces[7]", or the field alone where that is
// a path with an index already.
#pragma once

#include <grpcpp/support/status.h>

#include <string_view>

#include "absl/status/status.h"
#include "limn/v1/error_details.pb.h"

namespace limn::wire {

// What RetryInfo tells, in seconds.
inline constexpr int kRetryDelaySeconds = 1;

// An error, or ok, as gRPC says it. Messages travel in trailers, which are small: they are cut
// after 512 bytes, and bytes outside of ASCII become '?'. request_id: the call's name, for the
// ErrorInfo; empty for none. Thread-safe.
[[nodiscard]] grpc::Status ToGrpcStatus(const absl::Status& status,
                                        std::string_view request_id = {});

// The same as a message, for errors inside a stream. Code 0 and nothing else for ok.
[[nodiscard]] v1::RichStatus ToRichStatus(const absl::Status& status,
                                          std::string_view request_id = {});

// Back again: message, code and, when the details came along, the engine's ErrorDetail (reason,
// field, index, remedy, limit, retryable). Any other program's status is kept with its code and
// message.
[[nodiscard]] absl::Status FromGrpcStatus(const grpc::Status& status);

// The same for errors inside a stream.
[[nodiscard]] absl::Status FromRichStatus(const v1::RichStatus& status);

}  // namespace limn::wire
