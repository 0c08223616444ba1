// SPDX-License-Identifier: MIT
// Limit stencils: each scheme's limit point of a vertex as an affine combination of the vertex, its
// edge neighbours and what its faces hand to it. One shape for every scheme:
//   limit(v) = vertex * V + edges * mean(E_i) + faces * mean(value of face_i for v).
// Sources: Zheng and Cai 2005, Eqs. 5 and 6 (Doo-Sabin with modified first step), Eq. 1 and section
// 2 (Nasri's method); Halstead, Kass and DeRose 1993 (Catmull-Clark); Cheng et al., "Progressive
// interpolation using Loop subdivision surfaces", 2008, Eq. 3.
#pragma once

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

// Rows of single vertices whose edges and faces differ in weight, as where something is sharp:
//   limit(v) = V + sum_i edge_i (E_i - V) + sum_i face_i (centroid_i - V),
// i over the half-edges of the vertex's fan, in order.
struct WeightedRows {
  // Vertices, ascending, none on the boundary.
  std::vector<Index> vertex;
  // Weights of row r: [begin[r], begin[r + 1]) of edge and face. One more than there are rows.
  std::vector<std::size_t> begin = {0};
  std::vector<double> edge;
  std::vector<double> face;

  bool empty() const { return vertex.empty(); }
};

// The rows of all vertices, and what is proved of the operator L that they form.
struct LimitStencil {
  static constexpr std::uint16_t kNoRow = 0xffff;
  // Distinct rows.
  std::vector<LimitRow> rows;
  // Row of each vertex. Empty: all vertices have rows[0].
  Buffer<std::uint16_t> row_of;
  // These vertices' row_of is weighted_row, whose weights do not matter. Face rule: the centroid.
  WeightedRows weighted;
  std::uint16_t weighted_row = kNoRow;
  FaceRule face_rule = FaceRule::kCentroid;
  // Every eigenvalue of L is within [spectrum_low, spectrum_high]. spectrum_low <= 0: nothing
  // better is proved, L may be singular or indefinite, and methods that need a bound cannot be
  // used.
  double spectrum_low = 1;
  double spectrum_high = 1;

  const LimitRow& row(std::size_t vertex) const {
    return rows[row_of.empty() ? 0 : row_of[vertex]];
  }
  // Whether limit points see neighbours' points directly, not through centroids only.
  bool uses_edges() const;
  // Whether L is similar to a symmetric operator, diag(w) L, for some positive w. Rows of their own
  // are not.
  bool symmetric() const { return weighted.empty(); }
};

// Doo-Sabin with [ZC]'s modified first step, all vertices interpolated: limit(v) =
// (V + mean of the centroids) / 2. Twice the operator is I + diag(1/m_v) sum_f (1/m_f) 1 1', so the
// spectrum is within [1/2, 1] on every closed mesh.
[[nodiscard]] LimitStencil DooSabinModifiedStencil();

// Doo-Sabin with its own rule in the first step, Nasri's method: limit(v) = mean of the images. The
// operator is diag(1/m_v) sum_f P_f' a_f P_f where the circulant a_f has the eigenvalues 1, 1/2
// (twice) and 1/4, so the spectrum is within [1/4, 1] on every closed mesh: never singular.
[[nodiscard]] LimitStencil DooSabinStandardStencil();

// Catmull-Clark: one step of its rules for any arities, blended with a share `bilinear` (t, 0 to 1)
// of the bilinear rule (see RefineCatmullClark), folded into the limit stencil of quads. For a
// vertex of valence n, (n + 5) limit(v) = (n - 1 + 3t) V + 2 mean(E_i) + (4 - 3t) mean(centroids).
// Boundary vertices have the row of an identity: their curve is solved apart.
//
// Bounds. Row v times n (n + 5) is symmetric: diag(n (n - 1 + 3t)) + 2 adjacency + (4 - 3t) sum_f
// (1/m_f) 1_f 1_f', a sum over faces f of diag(n - 1 + 3t) + cycle_f + (4 - 3t) / m_f 1_f 1_f'
// against diag(n + 5). The adjacency cycle_f of an m-gon's sides has no eigenvalue below -k, k = 2
// for even m and 2 cos(pi / m) for odd. So the spectrum is within
//   [min over corners of (n - 1 + 3t - k) / (n + 5), 1],
// and spectrum_low is that minimum: for t = 1 at least 3/8 (2/7 with vertices of valence 2), for
// t = 1/2 at least 3/16 (1/14); for t = 0 positive where every face has a valence above 3 at its
// corners or an odd number of them, 0 or less where quads and larger even faces meet three at a
// vertex, as on cubes and even prisms, which are singular.
// Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: passes over vertices and corners; two bytes a vertex.
[[nodiscard]] absl::StatusOr<LimitStencil> CatmullClarkStencil(const Context& context,
                                                               const HalfEdgeMesh& mesh,
                                                               double bilinear = 0);

// Loop, for meshes of triangles: limit(v) = b V + (1 - b) mean(E_i) with b = 3 / (3 + 8 w), w as in
// LoopNeighbourWeight [PI Eq. 3]. Boundary vertices have the row of an identity.
//
// Bounds. Row v times n / (1 - b) is symmetric: a sum over triangles of (1 1' - I) / 2 +
// diag(b / (1 - b)) against diag(1 / (1 - b)). Such a pencil has the eigenvalue 1, the largest, and
// with s_i = (3 b_i - 1) / 2 at its corners the zeros of the derivative of (t - s_1) (t - s_2)
// (t - s_3). spectrum_low is the least of them all: s for one valence, at least 1/14 on every mesh.
// Vertices on the boundary are left out of their triangles.
// Errors: INVALID_OPTION, field "mesh.faces", for faces that are no triangles; CANCELLED,
// DEADLINE_EXCEEDED. Cost: passes over vertices and corners; two bytes a vertex.
[[nodiscard]] absl::StatusOr<LimitStencil> LoopStencil(const Context& context,
                                                       const HalfEdgeMesh& mesh);

// Gives vertices rows of their own. The bounds of the spectrum are no longer proved: spectrum_low
// becomes 0. Those that FixVertices has fixed before stay so. Errors: CANCELLED, DEADLINE_EXCEEDED.
[[nodiscard]] absl::Status SetWeightedRows(const Context& context, std::size_t vertex_count,
                                           WeightedRows rows, LimitStencil* stencil);

// Gives the vertices whose flag is set the row of an identity: they keep their points, the others
// see them as they are. What remains is a principal submatrix, similar to a symmetric one, so the
// bounds of the spectrum stay. fixed: one flag per vertex. Errors: CANCELLED, DEADLINE_EXCEEDED.
// Cost: a pass over vertices.
[[nodiscard]] absl::Status FixVertices(const Context& context, absl::Span<const std::uint8_t> fixed,
                                       LimitStencil* stencil);

}  // namespace limn
