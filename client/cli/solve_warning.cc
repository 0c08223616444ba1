// SPDX-License-Identifier: MIT
// What is to be said of a solve that ended before its tolerance was met.
#include "client/cli/solve_warning.h"

#include "absl/strings/str_format.h"
#include "client/cli/exit_status.h"

namespace limn::cli {

std::string SolveWarning(const v1::SolveReport& solve, const JobOptions& options) {
  // Feature values shape without a solve.
  if (solve.rule() == v1::SolveOptions::RULE_FEATURE_VALUES) return {};
  if (solve.converged() || options.tolerance == 0.0) return {};
  return absl::StrFormat(
      "warning: the tolerance was not met in %u %s, the residual is %.1e of the bounding box; "
      "allow more by --max-sweeps, or ask for less by --tolerance",
      solve.sweeps(), solve.sweeps() == 1 ? "sweep" : "sweeps", solve.residual());
}

void WarnAboutSolve(const v1::SolveReport& solve, const JobOptions& options) {
  const std::string warning = SolveWarning(solve, options);
  if (!warning.empty()) PrintError(warning);
}

}  // namespace limn::cli
