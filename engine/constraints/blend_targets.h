// SPDX-License-Identifier: MIT
// What is asked of Catmull-Clark and Loop surfaces beside the points of their vertices, checked
// against the mesh and brought into one form.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/constraints.h"
#include "engine/limit/limit_masks.h"
#include "engine/limit/surface_parameter.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

struct BlendTarget {
  // Where it stands in the constraints, for messages.
  bool of_normals = false;
  std::size_t index = 0;
  // Where it is; for vertices a corner of one of their faces.
  SurfaceParameter place = {};
  std::optional<Index> vertex = std::nullopt;
  // In the model's frame.
  std::optional<Vec3> point = std::nullopt;
  // Unit length.
  std::optional<Vec3> normal = std::nullopt;
  std::optional<Vec3> du = std::nullopt;
  std::optional<Vec3> dv = std::nullopt;
  // Of the constraints, which must outlive the target.
  absl::Span<const Index> region = {};

  // Such as "constraints.surface_points[2]".
  std::string path() const;
};

// All normals, then all surface_points. mesh: T^0. kind: of the scheme. constraints: as
// ValidateConstraints accepts them. points: those that vertices interpolate, in the model's frame;
// interpolated(v): whether vertex v is.
// Errors, each with path and index: INDEX_OUT_OF_RANGE for vertices, faces, corners and regions;
// INVALID_OPTION for places that are both or none, parameters outside of the face, constraints that
// ask for nothing, numbers that are not finite, normals and derivatives that are zero, parallel or
// not perpendicular to each other, derivatives at a vertex, points at interpolated vertices other
// than theirs, vertices that are named twice. Cost: linear in the constraints, and a byte a vertex.
// Thread-safe.
[[nodiscard]] absl::StatusOr<std::vector<BlendTarget>> BlendTargets(const Context& context,
                                                                    const HalfEdgeMesh& mesh,
                                                                    RingKind kind,
                                                                    const Constraints& constraints,
                                                                    absl::Span<const Vec3> points);

}  // namespace limn
