// SPDX-License-Identifier: MIT
// Limit stencils: each scheme's limit point of a vertex as an affine combination of the vertex, its
// edge neighbours and the centroids of its faces. One shape for every scheme:
//   limit(v) = vertex * V + edges * mean(E_i) + faces * mean(centroid of face_i).
// Sources: Zheng and Cai 2005, Eqs. 5 and 6 (Doo-Sabin with modified first step).
#pragma once

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// Weights of one vertex; they are not negative and add up to 1.
struct LimitRow {
  double vertex = 1;
  double edges = 0;
  double faces = 0;
};

// The rows of all vertices, and what is proved of the operator L that they form.
struct LimitStencil {
  // Distinct rows.
  std::vector<LimitRow> rows;
  // Row of each vertex. Empty: all vertices have rows[0].
  Buffer<std::uint16_t> row_of;
  // Every eigenvalue of L is within [spectrum_low, spectrum_high]; 0 < spectrum_low.
  double spectrum_low = 1;
  double spectrum_high = 1;

  const LimitRow& row(std::size_t vertex) const {
    return rows[row_of.empty() ? 0 : row_of[vertex]];
  }
  bool uses_edges() const;
};

// Doo-Sabin with [ZC]'s modified first step, all vertices interpolated: limit(v) =
// (V + mean of the centroids) / 2. Twice the operator is I + diag(1/m_v) sum_f (1/m_f) 1 1', so the
// spectrum is within [1/2, 1] on every closed mesh.
[[nodiscard]] LimitStencil DooSabinModifiedStencil();

// centroids[f] = mean of the points of face f's corners. Sizes: one point per vertex, one centroid
// per face. Cost: one pass over corners. Errors: CANCELLED, DEADLINE_EXCEEDED. Thread-safe.
[[nodiscard]] absl::Status FaceCentroids(const Context& context, const HalfEdgeMesh& mesh,
                                         absl::Span<const Vec3> points, absl::Span<Vec3> centroids);

// Row v of L applied to points, given their face centroids. Meshes from HalfEdgeMesh::Build.
[[nodiscard]] inline Vec3 LimitPoint(const HalfEdgeMesh& mesh, const LimitRow& row,
                                     absl::Span<const Vec3> points,
                                     absl::Span<const Vec3> centroids, std::size_t v) {
  const Index begin = mesh.fan_begin()[v];
  const Index end = mesh.fan_begin()[v + 1];
  Vec3 limit = row.vertex * points[v];
  if (row.faces != 0) {
    Vec3 sum = {0, 0, 0};
    for (Index i = begin; i < end; ++i) sum += centroids[mesh.face()[mesh.fan()[i]]];
    limit += (row.faces / (end - begin)) * sum;
  }
  if (row.edges != 0) {
    // Interior vertices: as many edges as faces, each half-edge of the fan leads to one neighbour.
    const PolygonWalk walk(mesh);
    Vec3 sum = {0, 0, 0};
    for (Index i = begin; i < end; ++i) sum += points[mesh.vertex()[walk.Next(mesh.fan()[i])]];
    limit += (row.edges / (end - begin)) * sum;
  }
  return limit;
}

}  // namespace limn
