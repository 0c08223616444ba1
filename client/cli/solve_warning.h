// SPDX-License-Identifier: MIT
// What is to be said of a solve that ended before its tolerance was met.
#pragma once

#include <string>

#include "client/cli/job_options.h"
#include "limn/v1/interpolate.pb.h"

namespace limn::cli {

// The warning with its remedy, or empty: the tolerance was met, or it was 0, which no solve meets
// and which asks for a number of sweeps.
[[nodiscard]] std::string SolveWarning(const v1::SolveReport& solve, const JobOptions& options);

// Prints it to stderr, if there is one.
void WarnAboutSolve(const v1::SolveReport& solve, const JobOptions& options);

}  // namespace limn::cli
