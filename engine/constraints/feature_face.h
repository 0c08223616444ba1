// SPDX-License-Identifier: MIT
// The images of a surface face. Source: Xu and Kondo, section 3.2.1 and, for a wrong sequence,
// section 3.2.3 (whose V_4 and V_5 are the V_5 and V_1 of its Fig. 5).
//
// Notation: V_i the face's vertices, E_i the edge from V_i to V_(i+1), C the mean of the vertices,
// e_i the EFV of E_i. The line E'_i is parallel to E_i through V_i + e_i (C - V_i), so its distance
// from E_i is e_i times that of C. V'_i = V_i + VFV_i (W_i - V_i), where W_i is the point in which
// E'_(i-1) and E'_i meet. With c = C - V_i, u and w the unit vectors from V_i along E_i and
// E_(i-1), N = u x w and c = a u + b w + (part along N):
//   W_i = V_i + (e_(i-1) + e_i) / 2 c + (e_i - e_(i-1)) / 2 (b w - a u).
// So with equal values W_i = V_i + e (C - V_i), whatever the face.
//   Not planar: the lines are skew, and W_i is the middle of the shortest segment between them,
// which is the formula as it stands.
//   Parallel neighbouring edges: where the sine of the angle between them is below 1/8 (angles
// above 172.8 or below 7.2 degrees), where lines of different values meet far away or nowhere, the
// last term is taken times 64 times the sine's square, so that all is continuous; at parallel
// edges, and at those of no length, the values' mean counts alone.
//   Concave: lines move towards C, also where that is away from the inside.
//   Wrong sequence: if the V_i wind once around C, seen along the face's average normal, so shall
// the W_i: they are sorted by their directions from C, as a periodic sequence, each at its nearest
// turn, and given to the vertices in that order with the same winding on the whole. Points in C
// (within 1e-12 of their vertex' distance) take the direction of their vertex; directions within
// 2^-40 of a turn count as equal and keep their order. Faces that do not wind so keep the sequence.
//   VFV divide the ways from V_i to the sorted W_i. They are not sorted again: where neighbouring
// VFV differ much, V'_i may be out of order, but VFV 0 always is the vertex itself.
//   e = 0 for both edges: W_i = V_i. e = 1 for both: W_i = C. VFV 0: V'_i = V_i; 1: V'_i = W_i.
// EFV 0, or VFV 0, everywhere: the surface of planar convex faces is the polyhedron.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "engine/base/vec3.h"

namespace limn {

struct FeatureFace {
  // Vertices, EFV of the edges that leave them and VFV, counter-clockwise; all of the same length,
  // 3 or more.
  absl::Span<const Vec3> point;
  absl::Span<const double> edge;
  absl::Span<const double> vertex;
};

// Images face by face; keeps room between the calls. Not thread-safe.
class FeatureImages {
 public:
  // Writes the images V'_i. Cost: linear in the vertices; n log n where values of edges differ.
  void Make(const FeatureFace& face, absl::Span<Vec3> images);

 private:
  struct Direction {
    std::int64_t angle;
    std::int64_t place;
    std::uint32_t corner;
  };
  // Puts the points W in their right order; see above.
  void Reorder(absl::Span<const Vec3> point, const Vec3& centre, absl::Span<Vec3> crossings);

  std::vector<Direction> directions_;
  std::vector<Vec3> sorted_;
};

}  // namespace limn
