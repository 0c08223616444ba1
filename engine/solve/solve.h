// SPDX-License-Identifier: MIT
// Solves L X = I for the control mesh X whose limit points L X are the given points I, matrix-free.
// Sources: Zheng and Cai 2005, Eqs. 6 and 7 (Jacobi, Gauss-Seidel) and section 3.4 (stopping);
// Golub and van Loan, Matrix Computations, section 10.1.5 (Chebyshev semi-iteration); Cheng et al.,
// "Progressive interpolation using Loop subdivision surfaces", 2008 (series).
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/stencil/limit_stencil.h"

namespace limn {

enum class SolveMethod {
  // Chebyshev where a bound of the spectrum is proved and does not make it slow, else conjugate
  // gradients.
  kAutomatic,
  // Chebyshev semi-iteration with the stencil's proven spectral bounds. No dot products. After k
  // sweeps the error is at most 1 / T_k((high + low) / (high - low)) of the start's in the norm
  // weighted with valences, on every mesh: for the modified rule 2e-13 after 17 sweeps. What stops
  // it is the longest residual, for which the proof loses a factor of sqrt(sum of valences / least
  // valence). Meshes of ordinary connectivity show none of it, and take at most 17 sweeps to 1e-12;
  // such as are made to show it, with large valences, arities and genus and the worst points on
  // them, take 18 (see tests/oracle/rotation_map.h).
  kChebyshev,
  // Each vertex solves its own equation with the values of the sweep before [ZC Eq. 7]. Converges
  // for the modified rule; for the standard one it may diverge where faces have six or more
  // corners.
  kJacobi,
  // The same with the newest values, in vertex order. Serial by nature.
  kGaussSeidel,
  // X <- X + (I - L X), which adds up the series of (1 - L)^k I: "progressive interpolation" [PI],
  // and [CC]'s series. Converges where the spectrum is within (0, 2), slowly where it comes near 0.
  kSeries,
  // Conjugate gradients; for operators that are not symmetric, where something is sharp, their
  // stabilised bi-orthogonal relative. A sweep is a step: a product with L, two for the relative.
  // Stops by the residual.
  kConjugateGradient,
};

// Solutions may be as much larger than what they interpolate as the inverse of this, and no more;
// see engine/solve/regularity.h.
inline constexpr double kLeastRegularEigenvalue = 1.0 / 32;

// Largest max_sweeps.
inline constexpr std::uint32_t kMaxSweeps = 10'000;

struct SolveOptions {
  SolveMethod method = SolveMethod::kAutomatic;
  // [ZC]'s EPS: stop when the longest move of a vertex in a sweep is at most this part of the
  // bounding box's diagonal; Chebyshev: the longest residual after it over the least eigenvalue
  // that is proved, but 1/4 at the least, which for Doo-Sabin is how far the solution may be away;
  // conjugate gradients: the longest residual. In
  // [0, 1). 0 runs max_sweeps, conjugate gradients until nothing is gained any more.
  double tolerance = 1e-12;
  // [ZC]'s ITE_MAX, 0 to kMaxSweeps. 0 leaves the given points as control points.
  std::uint32_t max_sweeps = 100;
};

// Checks the ranges above. Errors: INVALID_OPTION naming "solve.tolerance" or "solve.max_sweeps".
[[nodiscard]] absl::Status ValidateSolveOptions(const SolveOptions& options);

struct SolveReport {
  // The one that ran, never kAutomatic.
  SolveMethod method = SolveMethod::kChebyshev;
  std::uint32_t sweeps = 0;
  // Whether the tolerance was met within max_sweeps.
  bool converged = false;
  // What the last sweep was judged by, see `tolerance` (Chebyshev far from it: the residual before
  // the sweep).
  double last_update = 0;
  // The longest of I - L X, computed anew from X, over the bounding box's diagonal.
  double residual = 0;
  // The least eigenvalue of L as far as it is known: what conjugate gradients have seen of it, or
  // the bound that is proved. 0: nothing is known, or L is not positive definite.
  double least_eigenvalue = 0;
};

// What to solve. Everything belongs to the caller and must outlive the call.
struct SolveProblem {
  // From HalfEdgeMesh::Build.
  const HalfEdgeMesh& mesh;
  // L.
  const LimitStencil& stencil;
  // I, one point per vertex.
  absl::Span<const Vec3> points;
  // Diagonal of the bounding box, greater than 0 (for coincident points: any positive number).
  double scale = 1;
};

// Solves for X, starting from X = I. solution: one point per vertex, apart from problem.points.
//
// Not meeting the tolerance is no error: see SolveReport::converged. Errors: INVALID_OPTION, also
// for an iteration that diverges, for Chebyshev without a bound above 0, and for Gauss-Seidel where
// vertices have rows of their own; CANCELLED and DEADLINE_EXCEEDED, seen in every chunk of every
// sweep (Gauss-Seidel: every kDefaultGrain vertices); `solution` is then undefined. Progress: stage
// "solve", after each sweep.
//
// Cost: sweeps + 2 passes over corners; memory of one point per face, three per vertex (conjugate
// gradients five, or seven where L is not symmetric) and two indices per corner.
// Same bits for any number of threads. Thread-safe.
[[nodiscard]] absl::StatusOr<SolveReport> Solve(const Context& context, const SolveProblem& problem,
                                                const SolveOptions& options,
                                                absl::Span<Vec3> solution);

}  // namespace limn
