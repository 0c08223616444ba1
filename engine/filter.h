// SPDX-License-Identifier: MIT
// Filtering of a mesh by the terms of the interpolation series.
// Source: Chen et al., "Interpolating meshes of arbitrary topology by Catmull-Clark surfaces",
// section 2: with A M the limit points of a control mesh M,
//   M = A M + A (1 - A) M + A (1 - A)^2 M + ... + A (1 - A)^(n-1) M + (1 - A)^n M,
// from what is smooth to what is rough. Each term is multiplied by a gain of its own: low and high
// pass, smoothing, sharpening.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/interpolate.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

inline constexpr std::size_t kMostGains = 1024;

struct FilterOptions {
  // Of the terms A (1 - A)^i M; finite, at most kMostGains. 1 keeps a term.
  std::vector<double> gains;
  // Of (1 - A)^n M, which is what is left after n terms; finite. 0 leaves it out, 1 keeps it.
  double rest = 0;
};

// INVALID_OPTION with the field, such as "filter.gains[3]"; also for constraints that are for
// interpolation (surface.constraints: creases, corners and holes only), and for gains that are all
// missing. Cost: linear in the gains.
[[nodiscard]] absl::Status ValidateFilter(const FilterOptions& filter,
                                          const InterpolateOptions& surface);

// The filtered points, one per vertex, as control points of the mesh with the same faces. surface:
// says what A is: its scheme, rule, boundary and sharp constraints; the rest is not looked at. For
// Doo-Sabin and Catmull-Clark A is that of the rule asked for, or of the scheme's own.
//
// Guarantees: the same combination of terms relative to any origin: points count from the middle of
// the bounding box, so that the first gain scales the mesh in place. Gains and rest of 1 give M
// back, within rounding. Same bits for any number of threads.
//
// Errors: as ValidateFilter, HalfEdgeMesh::Build and Interpolate. Progress: stage "filter". Cost: a
// limit point per vertex and gain. Thread-safe; runs in the caller's arena.
[[nodiscard]] absl::StatusOr<Buffer<Vec3>> Filter(const Context& context, const PolygonMesh& mesh,
                                                  const FilterOptions& filter,
                                                  const InterpolateOptions& surface);

// Bytes of the arrays that Filter holds at its peak, the input not counted, as EstimateBytes.
[[nodiscard]] std::uint64_t EstimateFilterBytes(std::uint64_t vertices, std::uint64_t faces,
                                                std::uint64_t corners,
                                                const InterpolateOptions& surface,
                                                std::uint64_t boundary_edges = 0);

}  // namespace limn
