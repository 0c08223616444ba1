// SPDX-License-Identifier: MIT
// The time that a job takes: what admission knows of it before it is queued.
#pragma once

#include <cstdint>

#include "server/options_from_proto.h"

namespace limn {

// Milliseconds that the job may take on one processor, from what its header says: corners, sweeps,
// corners x 4^level of the surface, how it is encoded, constraints, gains of a filter, repair.
// Coefficients are those of the README's figures, on one machine; what matters is that jobs are
// compared by one measure. 1 at the least; saturates. A job to a chord tolerance counts as one of
// its finest level, and a mesh whose counts are not claimed by what its bytes may hold.
[[nodiscard]] std::uint64_t EstimateMilliseconds(const JobSpec& spec);

}  // namespace limn
