// SPDX-License-Identifier: MIT
// Moves the images of each interpolated vertex so that the surface passes through the given point,
// whatever the solve left over. Source: Zheng and Cai 2005, section 3.3, Eqs. 8 to 17.
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// The average normal of a closed polygon p(0) .. p(m - 1) [ZC Eq. 10], unit length, or (0, 0, 0)
// when the polygon encloses no area.
template <class Point>
Vec3 AverageNormal(std::size_t m, const Vec3& centroid, const Point& p) {
  Vec3 sum = {0, 0, 0};
  Vec3 last = p(m - 1) - centroid;
  for (std::size_t i = 0; i < m; ++i) {
    const Vec3 here = p(i) - centroid;
    sum += Cross(last, here);
    last = here;
  }
  return NormalizedOrZero(sum);
}

// For each vertex v: moves the points of its type-V face by the smallest amount [ZC Eq. 9] that
// puts their centroid on points[v] [Eq. 8] and all of them into the plane of their average normal
// [Eqs. 10, 11, 17]. Where that normal is zero they are only translated.
//
// mesh: T^0, closed. points: one per vertex. corners: M^1, one per half-edge, changed in place.
// Afterwards the centroids are the points up to rounding (a few units in the last place of the
// largest coordinate around). Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over corners.
// Same bits for any number of threads. Thread-safe.
[[nodiscard]] absl::Status PerturbToInterpolate(const Context& context, const HalfEdgeMesh& mesh,
                                                absl::Span<const Vec3> points,
                                                absl::Span<Vec3> corners);

}  // namespace limn
