// SPDX-License-Identifier: MIT
// Gauss-Seidel updates of the interpolation equations, in vertex order. Source: Zheng and Cai 2005,
// Eq. 7 and section 3.2.
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/solve/linear_system.h"
#include "engine/solve/solve.h"
#include "engine/stencil/limit_stencil.h"

namespace limn {

class GaussSeidel {
 public:
  // x: the control points, changed by each sweep. Both arguments must outlive the object.
  GaussSeidel(const SolveProblem& problem, absl::Span<Vec3> x);

  // Solves each vertex's equation once, with the newest values of the others. *largest: the longest
  // move over the problem's scale. Serial. Errors: CANCELLED and DEADLINE_EXCEEDED, seen every
  // kDefaultGrain vertices. Cost: two passes over corners; with FaceRule::kDooSabinImage as many
  // as the mean arity.
  [[nodiscard]] absl::Status Sweep(const Context& context, double* largest);

 private:
  Vec3 LimitPoint(std::size_t v) const;
  // Of corner h, in its face.
  Vec3 Image(Index h) const;
  // The weight of v's own point in its limit point.
  double Diagonal(std::size_t v) const;
  double InverseArity(Index face) const;

  const HalfEdgeMesh& mesh_;
  const LimitStencil& stencil_;
  absl::Span<const Vec3> points_;
  const RelativeLength length_;
  absl::Span<Vec3> x_;
  Buffer<Vec3> centroids_;
};

}  // namespace limn
