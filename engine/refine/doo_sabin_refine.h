// SPDX-License-Identifier: MIT
// Doo-Sabin refinement of points. Sources: Doo and Sabin 1978; Zheng and Cai 2005, Eqs. 1 and 4.
//
// A Doo-Sabin mesh M^k, k >= 1, is held by its dual: the quad split T^(k-1) -> T^k of the input's
// connectivity T^0 (engine/mesh/quad_split.h). M^k has one vertex per corner of T^(k-1), so its
// points are an array along those corners, and three types of faces:
//   type F: the corners of a face of T^(k-1), in order;
//   type E: of an edge with half-edges h and t = twin(h), counter-clockwise: next h, h, next t, t;
//   type V: the fan of corners around a vertex, counter-clockwise.
// At a boundary of T^(k-1), ghosts complete the faces of type E and V; see
// engine/refine/boundary_curve.h. They follow from the corners and the curve, so they are not kept.
// So T^k has one vertex per face of M^k (its centroid lies on the limit surface) and one quad per
// vertex of M^k, and no connectivity but that of T is ever built.
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
#include "engine/refine/boundary_curve.h"
#include "engine/refine/doo_sabin_rule.h"

namespace limn {

// First refinement of every face by the rule. control: one point per vertex; corners: one per
// half-edge. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over corners. Thread-safe.
[[nodiscard]] absl::Status FirstRefinement(const Context& context, const HalfEdgeMesh& mesh,
                                           absl::Span<const Vec3> control, absl::Span<Vec3> corners,
                                           FirstRule rule = FirstRule::kModified);

// The faces of M^k, k >= 2, that are not quads. Their number is the same at every level, and so
// are their fans but for a factor of 4. Without those of boundary vertices, which are gathered
// anew.
struct ExtraordinaryFans {
  // Vertices of T^1 with a valence other than 4.
  std::vector<Index> vertex;
  // Fan i is corner[begin[i] .. begin[i + 1]), half-edges of T^1, counter-clockwise.
  std::vector<Index> begin;
  std::vector<Index> corner;
};

// Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over vertices and faces.
[[nodiscard]] absl::StatusOr<ExtraordinaryFans> FindExtraordinaryFans(const Context& context,
                                                                      const HalfEdgeMesh& mesh);

// M^k -> M^(k+1) by [ZC Eq. 1].
// mesh: T^(k-1), k >= 1. fans: of T^0, looked at when k >= 2. corners: points of M^k, one per
// half-edge of `mesh`. refined: points of M^(k+1), one per half-edge of T^k, that is 4 per
// half-edge of `mesh`; must not overlap corners. boundary: of M^k; its own refinement is
// RefineBoundary's. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one
// pass over the refined points. Same bits for any number of threads. Thread-safe.
struct DooSabinLevel {
  const HalfEdgeMesh& mesh;
  const ExtraordinaryFans& fans;
  std::uint32_t k = 1;
  // Null or empty for closed meshes.
  const BoundaryCurve* boundary = nullptr;

  bool open() const { return boundary != nullptr && !boundary->empty(); }
};
[[nodiscard]] absl::Status RefineDooSabin(const Context& context, const DooSabinLevel& level,
                                          absl::Span<const Vec3> corners, absl::Span<Vec3> refined);

}  // namespace limn
