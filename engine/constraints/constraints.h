// SPDX-License-Identifier: MIT
// What a limit surface has to meet beside the smoothness of its scheme, and the check that it makes
// sense for a mesh. Sources: Zheng and Cai 2005, sections 2 (subsets), 4.1 (normals) and 4.2 (shape
// handles, after Brunet 1988).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/feature_values.h"
#include "engine/limit/surface_parameter.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// The surface's normal at an interpolated vertex is parallel to `normal`; its opposite means the
// same. Any finite length above zero. Doo-Sabin: not inside the mesh at vertices of two faces,
// around which the first refined mesh has only two points, and the surface no normal of its own.
struct NormalConstraint {
  Index vertex = 0;
  Vec3 normal = {0, 0, 0};
};

// Between these the guarantees hold to rounding; beyond, points or normals would lose digits.
inline constexpr double kLeastHandle = 1e-3;
inline constexpr double kLargestHandle = 1e3;

// The type-V face of the vertex, interpolated or not, is scaled about its centroid by this, from
// kLeastHandle to kLargestHandle; 1 changes nothing, above 1 flattens, below 1 sharpens. Point and
// normal of the surface at the vertex stay; on a boundary the curve near the vertex takes part.
struct ShapeHandle {
  Index vertex = 0;
  double value = 1;
};

// A chain of edges that are sharp, fully or for a few refinements; see engine/scheme/sharpness.h.
// Catmull-Clark and Loop.
struct CreaseConstraint {
  // Consecutive vertices of the chain; 2 or more.
  std::vector<Index> vertices;
  // One for the chain or one for each of its edges; 0 or more, kSharpForever for ever.
  std::vector<float> sharpness;
};

// A vertex that is sharp, likewise.
struct CornerConstraint {
  Index vertex = 0;
  float sharpness = 0;
};

// A point, a normal and first derivatives of the surface at a vertex or at a parameter of a face.
// Catmull-Clark and Loop; engine/constraints/blend.h says what is met, and how.
struct SurfaceConstraint {
  // Either one.
  std::optional<Index> vertex;
  std::optional<SurfaceParameter> parameter;
  // In the model's frame. Absent: the point stays where it is.
  std::optional<Vec3> point;
  // As NormalConstraint's.
  std::optional<Vec3> normal;
  // By u and v as evaluation counts them, at parameters only. Not zero, and not parallel.
  std::optional<Vec3> derivative_u;
  std::optional<Vec3> derivative_v;
  // Faces of T^2 that may change; see engine/limit/tessellation.h for their numbers. Empty: chosen
  // by the engine.
  std::vector<Index> region;
};

struct Constraints {
  // Vertices to interpolate, each at most once, in any order. Absent: all of them, or none with
  // feature values. The others keep their given points as control points and only shape the
  // surface. A corner of the boundary (a vertex of one face) is always met.
  std::optional<std::vector<Index>> interpolate;
  // At most one per vertex, at interpolated vertices only.
  std::vector<NormalConstraint> normals;
  // At most one per vertex. Doo-Sabin.
  std::vector<ShapeHandle> shape_handles;
  // At most one per vertex, normals counted.
  std::vector<SurfaceConstraint> surface_points;
  // The last one that names an edge or a vertex counts.
  std::vector<CreaseConstraint> creases;
  std::vector<CornerConstraint> corners;
  // Faces that support the surface but are not part of it. Catmull-Clark and Loop.
  std::vector<Index> holes;
  // Instead of a solve and its first refinement; see engine/constraints/features.h, also for what
  // becomes of the above. Doo-Sabin.
  std::optional<FeatureValues> features;

  bool interpolates_all() const { return !interpolate.has_value() && !features.has_value(); }
};

// Checks everything said above. Errors, each with the field's path in the contract's words, such as
// "constraints.normals[3].vertex", and its index: INDEX_OUT_OF_RANGE; INVALID_OPTION for repeated
// vertices, for normals that are zero or not finite or at vertices that are not interpolated, for
// handles out of their range; CANCELLED, DEADLINE_EXCEEDED. Cost: linear in the
// constraints, and one bit a vertex. What is about edges and faces is checked when there is a
// mesh: creases, corners and holes by engine/constraints/creases.h, surface_points by
// engine/constraints/blend_targets.h, feature values by MakeFeatureTable. Thread-safe.
[[nodiscard]] absl::Status ValidateConstraints(const Context& context,
                                               const Constraints& constraints,
                                               std::size_t vertex_count);

// Checks that no normal stands at a vertex of two faces inside the mesh; Doo-Sabin. constraints: as
// ValidateConstraints accepts them. Errors: INVALID_OPTION, naming the field, such as
// "constraints.normals[3].vertex"; CANCELLED, DEADLINE_EXCEEDED. Cost: linear in the normals.
// Thread-safe.
[[nodiscard]] absl::Status ValidateDooSabinNormals(const Context& context,
                                                   const Constraints& constraints,
                                                   const HalfEdgeMesh& mesh);

}  // namespace limn
