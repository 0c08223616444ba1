// SPDX-License-Identifier: MIT
// Which flags of a job go together.
#pragma once

#include "absl/status/status.h"
#include "client/cli/job_options.h"

namespace limn::cli {

// Ok, or INVALID_OPTION naming a flag: for what a server would refuse of the flags alone, and for
// flags that it would not look at. options: as checked by the flags one by one. Thread-safe.
[[nodiscard]] absl::Status CheckTogether(const JobOptions& options);

}  // namespace limn::cli
