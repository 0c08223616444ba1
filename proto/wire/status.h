// SPDX-License-Identifier: MIT
// The one map between errors of the engine and gRPC status. Details travel as google.rpc.Status in
// the trailer "grpc-status-details-bin": ErrorInfo with every error, BadRequest for bad input,
// RetryInfo for RESOURCE_EXHAUSTED by a queue and for UNAVAILABLE.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "limn/v1/error_details.pb.h"

namespace limn::wire {

// An error, or ok, as gRPC says it. Thread-safe.
[[nodiscard]] grpc::Status ToGrpcStatus(const absl::Status& status);

// The same as a message, for errors inside a stream.
[[nodiscard]] v1::RichStatus ToRichStatus(const absl::Status& status);

// Back again: message, code and, when the details came along, the engine's ErrorDetail (reason,
// field, index). Any other program's status is kept with its code.
[[nodiscard]] absl::Status FromGrpcStatus(const grpc::Status& status);

}  // namespace limn::wire
