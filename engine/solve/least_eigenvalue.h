// SPDX-License-Identifier: MIT
// Whether a limit operator has a small eigenvalue, told by the operator alone: not by the points
// that are interpolated, nor by how far, and with which method, its equations are solved.
// Sources: Golub and van Loan, Matrix Computations, section 10.1; Kuczynski and Wozniakowski,
// "Estimating the largest eigenvalue by the power and Lanczos algorithms with a random start",
// 1992, Theorem 4.2 (how many steps are enough).
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/stencil/limit_operator.h"

namespace limn {

// Products with L at the most.
inline constexpr std::uint32_t kMaxProbeSteps = 80;

// Whether L has an eigenvalue below `bound`. limit: symmetric(), its spectrum below 1. The Lanczos
// process runs from a start of random signs and lengths, which are the same for the same number of
// vertices. What it finds is there, whatever the start. It ends when it has found one, when none
// can be left that it had not seen (but with a chance of less than 1e-3 for such starts), or after
// kMaxProbeSteps: up to 16 million vertices what is below `bound` - 1/100 is found, with the same
// exception. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: a product with L and four passes over
// vertices for each step, 10 to 25 steps where L is well conditioned; memory of three points and a
// number a vertex, and the face values. Same result for any number of threads. Thread-safe.
[[nodiscard]] absl::StatusOr<bool> HasEigenvalueBelow(const Context& context,
                                                      const LimitOperator& limit, double bound);

}  // namespace limn
