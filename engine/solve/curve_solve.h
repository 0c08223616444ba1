// SPDX-License-Identifier: MIT
// Control points of boundary curves that pass through given points: the one-dimensional case of the
// interpolation problem, solved directly. Sources: Zheng and Cai 2005, section 2, for the problem;
// the inverse of a tridiagonal Toeplitz matrix is a geometric series (de Boor, A Practical Guide to
// Splines, for B-splines).
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/refine/boundary_curve.h"

namespace limn {

// A curve's limit point: vertex * V + neighbour * (V_before + V_after). vertex > 2 neighbour > 0,
// vertex + 2 neighbour = 1.
struct CurveStencil {
  double vertex = 0.75;
  double neighbour = 0.125;
};
// Doo-Sabin: quadratic B-splines.
inline constexpr CurveStencil kQuadraticCurve = {.vertex = 0.75, .neighbour = 0.125};
// Catmull-Clark and Loop: cubic B-splines.
inline constexpr CurveStencil kCubicCurve = {.vertex = 2.0 / 3, .neighbour = 1.0 / 6};

// Vertices are numbered along the curve: vertex i is the one that boundary half-edge i leaves.
struct CurveProblem {
  // Successors and predecessors.
  const BoundaryCurve& curve;
  // Given points.
  absl::Span<const Vec3> points;
  // Vertices that keep their given point as control point: ends of independent pieces.
  absl::Span<const std::uint8_t> fixed;
  CurveStencil stencil = kQuadraticCurve;
  // Where the rows differ: the weight of each vertex in its own limit point, at least that of the
  // stencil, whose place it takes; the neighbours share the rest. Empty: all as the stencil.
  absl::Span<const double> vertex_weights = {};
};

// control: one point per vertex of the curve, apart from problem.points. Each is its own given
// point plus a symmetric sum of differences to the others nearby, mirrored at fixed vertices: exact
// to rounding (the series is cut at 2^-56 of itself, some 22 terms), without iteration, and the
// same bits from both sides of the boundary, and wherever the boundary is cut at fixed vertices.
// With vertex_weights: by sweeps over differences to the given points instead, which halve the
// error each, until 2^-56 of it is left; same bits from both sides too. Errors: CANCELLED,
// DEADLINE_EXCEEDED. Cost: the terms or sweeps, for each vertex. Thread-safe.
[[nodiscard]] absl::Status SolveCurves(const Context& context, const CurveProblem& problem,
                                       absl::Span<Vec3> control);

// *largest: the largest coordinate of given point less limit point, over all vertices that are not
// fixed. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: linear.
[[nodiscard]] absl::Status CurveResidual(const Context& context, const CurveProblem& problem,
                                         absl::Span<const Vec3> control, double* largest);

}  // namespace limn
