// SPDX-License-Identifier: MIT
// Limit stencils: each scheme's limit point of a vertex as an affine combination of the vertex, its
// edge neighbours and what its faces hand to it. One shape for every scheme:
//   limit(v) = vertex * V + edges * mean(E_i) + faces * mean(value of face_i for v).
// Sources: Zheng and Cai 2005, Eqs. 5 and 6 (Doo-Sabin with modified first step), Eq. 1 and section
// 2 (Nasri's method).
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
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

// What a face hands to its vertices.
enum class FaceRule {
  // Its centroid, to all of them.
  kCentroid,
  // To each its image in a Doo-Sabin step [ZC Eq. 1].
  kDooSabinImage,
};

// The rows of all vertices, and what is proved of the operator L that they form.
struct LimitStencil {
  // Distinct rows.
  std::vector<LimitRow> rows;
  // Row of each vertex. Empty: all vertices have rows[0].
  Buffer<std::uint16_t> row_of;
  FaceRule face_rule = FaceRule::kCentroid;
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

// Doo-Sabin with its own rule in the first step, Nasri's method: limit(v) = mean of the images. The
// operator is diag(1/m_v) sum_f P_f' a_f P_f where the circulant a_f has the eigenvalues 1, 1/2
// (twice) and 1/4, so the spectrum is within [1/4, 1] on every closed mesh: never singular.
[[nodiscard]] LimitStencil DooSabinStandardStencil();

// Gives the vertices whose flag is set the row of an identity: they keep their points, the others
// see them as they are. What remains is a principal submatrix, similar to a symmetric one, so the
// bounds of the spectrum stay. fixed: one flag per vertex. Errors: CANCELLED, DEADLINE_EXCEEDED.
// Cost: a pass over vertices.
[[nodiscard]] absl::Status FixVertices(const Context& context, absl::Span<const std::uint8_t> fixed,
                                       LimitStencil* stencil);

}  // namespace limn
