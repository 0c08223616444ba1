// SPDX-License-Identifier: MIT
// A call's deadline on the clock that the rest of the server uses.
#pragma once

#include <grpc/support/time.h>

#include <chrono>
#include <optional>

namespace limn {

// When a call has to end; nothing when it has no deadline, or one that is a century away or more:
// gRPC's own conversion to std::chrono overflows there, so that patience without end would become
// none at all. deadline: ServerContext's raw_deadline(). Thread-safe.
[[nodiscard]] std::optional<std::chrono::steady_clock::time_point> DeadlineOf(
    gpr_timespec deadline);

}  // namespace limn
