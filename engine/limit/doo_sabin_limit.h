// SPDX-License-Identifier: MIT
// Limit points and normals of a Doo-Sabin surface, one for each face of the refined mesh M^k.
// Source: Doo and Sabin 1978: a face shrinks to its centroid, and its first harmonic spans the
// tangent plane there.
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/refine/doo_sabin_refine.h"

namespace limn {

// Where to write: points and normals of the vertices of T^k, numbered [vertices | edges | faces]
// of T^(k-1). normals may be empty. With vertices_only, only the first vertex_count() are written.
struct LimitOutput {
  absl::Span<Vec3> points;
  absl::Span<Vec3> normals;
  bool vertices_only = false;
};

// level: T^(k-1) and boundary as in RefineDooSabin. Points are relative to the boundary's origin,
// as corners are. corners: points of M^k, one per half-edge of T^(k-1). Normals are unit vectors,
// outward for counter-clockwise faces, or (0, 0, 0) where the first harmonic spans no plane.
// Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one pass. Same bits for any number of threads.
// Thread-safe.
[[nodiscard]] absl::Status DooSabinLimit(const Context& context, const DooSabinLevel& level,
                                         absl::Span<const Vec3> corners, const LimitOutput& output);

}  // namespace limn
