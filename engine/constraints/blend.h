// SPDX-License-Identifier: MIT
// Normals, first derivatives and points anywhere on a Catmull-Clark or Loop surface, by moving
// control points of the twice refined mesh T^2 near each.
// Source: Chen et al., "Interpolating meshes of arbitrary topology by Catmull-Clark surfaces",
// sections 3 to 7: the surface is blended with its image under an affine map. Here the control
// points are blended, P + w (T(P) - P), so that the result is a surface of the same scheme, as
// smooth as any, and the constraint is met because subdivision commutes with affine maps: also at
// extraordinary vertices, on boundaries, at what is sharp.
//
// Maps: engine/constraints/blend_map.h. Regions: engine/constraints/blend_region.h. A region of the
// engine's choice stays off the supports of the vertices that are interpolated and of the other
// constraints, and then all are met one by one. Constraints that leave no room for that, and given
// regions that reach such supports, are met together: see engine/constraints/blend_joint.h.
// Boundaries and what is sharp move along where a region reaches them. A normal at a vertex of
// which one face alone lies between two sharp edges hangs on how the surface bends there: it is met
// one by one only, and refused as a contradiction where it would have to be met together with
// others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/constraints/blend_targets.h"
#include "engine/limit/primal_surface.h"

namespace limn {

struct BlendReport {
  // Constraints met, and those of them that had to be met together with others or with vertices.
  std::uint64_t constraints = 0;
  std::uint64_t together = 0;
  // As evaluated on the result. In model units, radians, and relative to the derivative.
  double max_point_error = 0;
  double max_normal_deviation = 0;
  double max_derivative_error = 0;
  // Control points of T^2 that were moved; ascending.
  std::vector<Index> moved = {};
};

struct BlendInput {
  absl::Span<const BlendTarget> targets;
  // Of the vertices of T^0: 1 for those whose points are to stay where they are.
  absl::Span<const std::uint8_t> stays;
  // Diagonal of the model's bounding box.
  double scale = 1;
  // Control points in all regions together; see MostBlendPoints.
  std::uint64_t most_points = std::numeric_limits<std::uint64_t>::max();
};

// Control points that regions may have in all: room for six rings around each constraint at the
// mesh's mean valence, three at vertices where all are interpolated, and for some vertices of
// larger valence. Cost: constant.
[[nodiscard]] std::uint64_t MostBlendPoints(std::uint64_t vertices, std::uint64_t half_edges,
                                            const Constraints& constraints);

// surface: of depth 1 (quads) or 2 (triangles), so that its points are those of T^2.
//
// Guarantees: points are met within 1e-10 of `scale`, derivatives within 1e-10 of their length,
// normals within 1e-10 rad (as evaluation has them; at vertices as engine/limit/vertex_limit.h has
// them), or the call fails; the points at vertices that stay move by no more. Only points named in
// `moved` change, the others not by a bit.
//
// Errors: INVALID_OPTION with the path of the constraint: tangents are asked for where the surface
// has no tangent plane; the region is too small; constraints contradict each other (both are
// named); points are more than 1e5 diagonals, derivatives by a factor of more than 1e5 away from
// what the surface has. LIMIT_EXCEEDED when a region touches more than 256 other places, more than
// 65,536 places would have to be met together, one of them with more than 4,096 points around it,
// or regions have more than most_points. CANCELLED, DEADLINE_EXCEEDED. After an error the surface's
// points are anything.
//
// Cost: some hundred control points for each constraint; for those that are met together see
// engine/constraints/blend_joint.h. Same bits for any number of threads.
[[nodiscard]] absl::StatusOr<BlendReport> Blend(const Context& context, const BlendInput& input,
                                                PrimalSurface* surface);

}  // namespace limn
