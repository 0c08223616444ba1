// SPDX-License-Identifier: MIT
// The boundary of a Doo-Sabin mesh M^k: a quadratic B-spline curve, and the ghost points mirrored
// in it that make boundary vertices and edges of T^(k-1) ordinary faces of M^k.
// Source: the one-dimensional case of Doo and Sabin 1978 (Chaikin's rule), with mirror points
// spread over each fan so that the rule of a 2m-gon keeps the curve for every m.
//
//    W_b o-------o W_a       A boundary half-edge h of T^(k-1) runs from a to b with its face on
//        |  E(h) |           the left. The curve has the image B_a = start of h and B_b = end of
//   ==B_b+=======+B_a==      h; W are the corners' points, G = 2 B - W their ghosts. Type-E face,
//        |       |           counter-clockwise: W_b, W_a, G_a, G_b.
//    G_b o-------o G_a
//
// A boundary vertex with the corners W_1 ... W_m (counter-clockwise) has the type-V face W_1 ...
// W_m, G_m ... G_1 with G_j = 2 B_j - W_j, where B_1 is the start of the half-edge that leaves
// along the boundary, B_m the end of the one that enters, c their mean, d = (B_1 - B_m) / 2, and
//   B_j = c + d cos((j - 1/2) pi / m) / cos(pi / (2 m)).
// Those B are c plus a first harmonic of the 2m-gon, which refinement halves: so the centroid is c
// and the limit boundary is the B-spline exactly. A corner, m = 1, is sharp: its face is W, 2 B_in
// - W, the fourth point, 2 B_out - W, with the centroid on the corner itself.
//
// A vertex of m faces that is sharp on purpose, where plane faces meet (engine/constraints/
// features.h), is the quarter of a face with 4m sides: with t_j = (j - 1/2) pi / (2 m), C the
// vertex and L(t) = (a cos t + b sin t) / cos t_1, a = B_1 - C, b = B_m - C, the points W_j are C +
// L(t_j)
// + r_j, and what r_j is in the other quarters is odd about both curves: so r has no mean and no
// first harmonic. The centroid is C, and B_1 and B_m go half way to C at each step, as the curves'
// own do. For m = 1 it is the face above.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// The curve along the boundary half-edges of T^(k-1), numbered 0 .. size() - 1; at k = 1 in the
// order of the half-edges. Empty for closed meshes. Plain data.
struct BoundaryCurve {
  // The half-edge, its successor and its predecessor along the boundary.
  Buffer<Index> half_edge;
  Buffer<Index> next;
  Buffer<Index> previous;
  // The surface's point at the vertex that the half-edge leaves: an interpolated vertex's given
  // point, to the bit.
  Buffer<Vec3> centre;
  // B near the vertex that the half-edge leaves, and near the one that it enters.
  Buffer<Vec3> start;
  Buffer<Vec3> end;
  // 1 where the vertex that the half-edge leaves is sharp with any number of faces. Empty: nowhere;
  // vertices of one face have `centre` as their corner in any case.
  Buffer<std::uint8_t> sharp;
  // The points above are in the model's frame; those of corners are relative to this origin. So two
  // meshes that share a boundary share it to the last bit, wherever their middles are.
  Vec3 origin = {0, 0, 0};

  std::size_t size() const { return half_edge.size(); }
  bool empty() const { return half_edge.empty(); }
  bool IsSharp(std::size_t i) const { return !sharp.empty() && sharp[i] != 0; }
  // Sides of the type-V face at the vertex that half-edge i leaves, one of m faces.
  std::size_t SidesAt(std::size_t i, std::size_t m) const {
    return m == 1 || IsSharp(i) ? 4 * m : 2 * m;
  }
  // The number of boundary half-edge h; the curve must be that of k = 1, and h one of its
  // half-edges. Cost: logarithmic.
  Index Find(Index h) const;
};

// The half-edges, successors and predecessors of the boundary of T^0, without points.
// mesh: from HalfEdgeMesh::Build. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: a pass over
// half-edges. Same result for any number of threads.
[[nodiscard]] absl::StatusOr<BoundaryCurve> FindBoundary(const Context& context,
                                                         const HalfEdgeMesh& mesh);

// What the curve of M^1 is placed by. Vertices are numbered along the curve: vertex i is the one
// that boundary half-edge i leaves.
struct BoundaryPlacement {
  // T^0.
  const HalfEdgeMesh& mesh;
  // Given points and control points, in the model's frame.
  absl::Span<const Vec3> points;
  absl::Span<const Vec3> control;
  // Whether the curve shall pass through the given point. Corners always do.
  absl::Span<const std::uint8_t> interpolated;
};

// Sets centre, start and end of a curve from FindBoundary: B = (3 V + V_other) / 4, then moved by
// the mean error of the two B around each interpolated vertex, so that it is met exactly.
// *residual: the largest coordinate of that error. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost:
// linear in the curve.
[[nodiscard]] absl::Status PlaceBoundary(const Context& context, const BoundaryPlacement& placement,
                                         BoundaryCurve* curve, double* residual);

// A type-V face of M^k at a boundary vertex, relative to the curve's origin.
struct BoundaryFace {
  // Half-edges that leave the vertex, counter-clockwise: the corners of the first m points.
  std::vector<Index> corner;
  // 2m points, counter-clockwise, the ghosts last; 4m when m = 1 or the vertex is sharp.
  std::vector<Vec3> point;
};

// Fills *face with that of the vertex that boundary half-edge i leaves. mesh: T^(k-1); corners: the
// points of M^k. Cost: linear in m. Thread-safe.
void GatherBoundaryFace(const HalfEdgeMesh& mesh, const BoundaryCurve& curve, const Vec3* corners,
                        Index i, BoundaryFace* face);

// The type-E face of boundary half-edge i: W_b, W_a, G_a, G_b, relative to the curve's origin.
std::array<Vec3, 4> BoundaryEdgeFace(const HalfEdgeMesh& mesh, const BoundaryCurve& curve,
                                     const Vec3* corners, Index i);

// The curve of M^(k+1) along the boundary of T^k, from that of M^k: half-edge i gives 2i and 2i
// + 1. mesh: T^(k-1). Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: linear in the curve.
[[nodiscard]] absl::StatusOr<BoundaryCurve> RefineBoundary(const Context& context,
                                                           const HalfEdgeMesh& mesh,
                                                           const BoundaryCurve& curve);

}  // namespace limn
