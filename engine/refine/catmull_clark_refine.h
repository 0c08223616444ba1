// SPDX-License-Identifier: MIT
// Catmull-Clark refinement of points. Sources: Catmull and Clark, "Recursively generated B-spline
// surfaces on arbitrary topological meshes", 1978; DeRose, Kass and Truong 1998 for creases.
//
// The connectivity is that of SplitIntoQuads. With F the centroid of a face, n the valence of a
// vertex, E_i and F_i the ends of its edges and the centroids of its faces:
//   edge:    (V + E + F + F') / 4, a sharp one (V + E) / 2;
//   vertex:  ((n - 2) V + mean E_i + mean F_i) / n; on a crease (6 V + E + E') / 8; a corner V.
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/scheme/sharpness.h"

namespace limn {

// The points of T^(k+1) from those of T^k.
// level: T^k, k >= 0, of any arities, and its sharpness. points: one per vertex of T^k. refined:
// vertex_count() + edge_count() + face_count(), numbered [vertices | edges | faces]; must not
// overlap points. bilinear: 0 for the rules above; share, up to 1, of the bilinear rule (a smooth
// vertex stays, a smooth edge's point is its midpoint), which makes interpolation with this as its
// first step solvable on every mesh; see CatmullClarkStencil.
// Errors: INTERNAL when a span's size does not fit; CANCELLED, DEADLINE_EXCEEDED. Cost: three
// passes over half-edges; a fourth array is read where there are creases. Same bits for any number
// of threads. Thread-safe.
[[nodiscard]] absl::Status RefineCatmullClark(const Context& context, const SurfaceLevel& level,
                                              absl::Span<const Vec3> points,
                                              absl::Span<Vec3> refined, double bilinear = 0);

}  // namespace limn
