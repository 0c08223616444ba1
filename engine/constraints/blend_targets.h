// SPDX-License-Identifier: MIT
// What is asked of Catmull-Clark and Loop surfaces beside the points of their vertices, checked
// against the mesh and brought into one form.
#pragma once

#include <cstddef>
#include <cstdint>
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
  // The vertex that the place is at, also where a parameter says so.
  std::optional<Index> on_vertex = std::nullopt;
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

// What targets are checked against.
struct BlendMesh {
  // T^0.
  const HalfEdgeMesh& mesh;
  // Of the scheme.
  RingKind kind = RingKind::kQuads;
  // As Sharpness::hole.
  absl::Span<const std::uint8_t> hole = {};
  // Those that vertices interpolate, in the model's frame.
  absl::Span<const Vec3> points = {};
};

// All normals, then all surface_points. constraints: as ValidateConstraints accepts them.
// Errors, each with path and index: INDEX_OUT_OF_RANGE for vertices, faces, corners and regions;
// INVALID_OPTION for places that are both or none, parameters outside of the face or in a hole,
// constraints that
// ask for nothing, numbers that are not finite, normals and derivatives that are zero, parallel or
// not perpendicular to each other, derivatives at a vertex, points at interpolated vertices other
// than theirs (also where a parameter is at the vertex), vertices that are named twice. Cost:
// linear in the constraints, and a byte a vertex. Thread-safe.
[[nodiscard]] absl::StatusOr<std::vector<BlendTarget>> BlendTargets(const Context& context,
                                                                    const BlendMesh& mesh,
                                                                    const Constraints& constraints);

}  // namespace limn
