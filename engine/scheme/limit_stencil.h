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

}  // namespace limn
