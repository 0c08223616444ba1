// SPDX-License-Identifier: MIT
// Loop refinement of points. Sources: Loop, "Smooth subdivision surfaces based on triangles", 1987
// (with its own beta per valence); Hoppe et al. 1994 and DeRose, Kass and Truong 1998 for creases.
//
// The connectivity is that of SplitIntoTriangles. With n the valence of a vertex, E_i the ends of
// its edges, A and B the vertices across an edge:
//   edge:    3/8 (V + E) + 1/8 (A + B), a sharp one (V + E) / 2;
//   vertex:  (1 - w) V + w mean E_i, w = 5/8 - (3/8 + cos(2 pi / n) / 4)^2;
//            on a crease (6 V + E + E') / 8; a corner V.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/scheme/sharpness.h"

namespace limn {

// The w above, the weight that a smooth vertex of valence n, 2 or more, gives to its neighbours.
[[nodiscard]] double LoopNeighbourWeight(std::size_t n);

// The points of T^(k+1) from those of T^k.
// level: T^k, k >= 0, of triangles, and its sharpness. points: one per vertex of T^k. refined:
// vertex_count() + edge_count(), numbered [vertices | edges]; must not overlap points.
// Errors: as RequireTriangles; INTERNAL when a span's size does not fit; CANCELLED,
// DEADLINE_EXCEEDED. Cost: two passes over half-edges; one more array is read where there are
// creases. Same bits for any number of threads. Thread-safe.
[[nodiscard]] absl::Status RefineLoop(const Context& context, const SurfaceLevel& level,
                                      absl::Span<const Vec3> points, absl::Span<Vec3> refined);

}  // namespace limn
