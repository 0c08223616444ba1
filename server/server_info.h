// SPDX-License-Identifier: MIT
// What the server says of itself.
#pragma once

#include "limn/v1/server_info.pb.h"
#include "server/limits.h"

namespace limn {

// threads: those that jobs are computed on.
[[nodiscard]] v1::GetServerInfoResponse MakeServerInfo(const ServerLimits& limits, int threads);

}  // namespace limn
