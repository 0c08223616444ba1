// SPDX-License-Identifier: MIT
// Conjugate gradients for the interpolation equations, for operators that are symmetric up to a
// scaling of rows, and their stabilised bi-orthogonal relative for those that are not.
// Sources: Hestenes and Stiefel 1952; van der Vorst, "Bi-CGSTAB", 1992; Golub and van Loan, Matrix
// Computations, section 10.1 (eigenvalues by the Lanczos process behind conjugate gradients).
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/vec3.h"
#include "engine/solve/linear_system.h"

namespace limn {

struct KrylovOptions {
  // Ends when the longest residual, computed anew from x, is at most this part of the system's
  // scale.
  double tolerance = 0;
  // At the most.
  std::uint32_t max_steps = 100;
};

struct KrylovResult {
  std::uint32_t steps = 0;
  // Whether the true residual met the tolerance.
  bool converged = false;
  // L turned out not to be positive definite, or residuals grew.
  bool broke_down = false;
  // The least eigenvalue of L that the residual gave a hint of (Ritz value; never below the least
  // one but for rounding). 1 where the start is the solution; 0 after a breakdown. 0 from
  // BiconjugateGradientStabilized, which does not see it.
  double least_eigenvalue = 0;
  // The longest of the true residuals, over the system's scale.
  double residual = 0;
};

// Solves L x = I from x = I. weights: positive, such that diag(weights) L is symmetric
// (LimitOperator::SymmetricWeights). When the recursive residual meets the tolerance the true one
// is looked at, and decides; if it does not, the method starts again from there, as long as that
// helps. x is never worse than I itself, which it is set to otherwise. Errors: CANCELLED,
// DEADLINE_EXCEEDED. Cost: a product with L, three sums and as many passes for each step; memory of
// three points a vertex. Same bits for any number of threads.
[[nodiscard]] absl::StatusOr<KrylovResult> ConjugateGradient(LinearSystem* system,
                                                             absl::Span<const double> weights,
                                                             const KrylovOptions& options,
                                                             absl::Span<Vec3> x);

// The same for any L; two products a step, memory of five points a vertex. No bound of its steps is
// known; it is tried.
[[nodiscard]] absl::StatusOr<KrylovResult> BiconjugateGradientStabilized(
    LinearSystem* system, const KrylovOptions& options, absl::Span<Vec3> x);

}  // namespace limn
