// SPDX-License-Identifier: MIT
// The planes of plane faces, and the mesh cut along them. Source: Xu and Kondo, section 3.2.2: what
// surrounds a plane face is an open surface that ends at the face's edges.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/feature_values.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// The given points, relative to an origin, and the diagonal of their bounding box (not 0).
struct PlanePoints {
  absl::Span<const Vec3> points;
  double scale = 1;
};

// Points with which all plane faces are planar: empty when they are as given, each corner within
// 1e-13 of the diagonal of its face's plane. Else the corners of plane faces are moved into the
// planes through their faces' means along the average normals [ZC Eq. 10], by the shortest way into
// all the planes around a vertex.
//
// Errors, INVALID_OPTION, "constraints.features" with the number of the face or the vertex as
// index: a face whose corners lie on a line; a vertex whose planes do not meet in a point, or
// nearly not (a further plane counts from an angle of 1e-3 on), or only further away than an eighth
// of its shortest edge. CANCELLED, DEADLINE_EXCEEDED. Cost: a pass over the corners. Thread-safe.
[[nodiscard]] absl::StatusOr<Buffer<Vec3>> FlattenPlaneFaces(const Context& context,
                                                             const HalfEdgeMesh& mesh,
                                                             const FeatureTable& table,
                                                             const PlanePoints& given);

// T^0 with every plane face a component of its own: the same faces and corners; vertices of plane
// faces are there once for each run of faces between two cut edges, first those of T^0, each for
// one of its runs, then the others. plane: one per face of mesh, which is from HalfEdgeMesh::Build.
// Errors: LIMIT_EXCEEDED, CANCELLED, DEADLINE_EXCEEDED. Cost: as HalfEdgeMesh::Build. Same result
// for any number of threads.
[[nodiscard]] absl::StatusOr<HalfEdgeMesh> CutAlongPlanes(const Context& context,
                                                          const HalfEdgeMesh& mesh,
                                                          absl::Span<const std::uint8_t> plane);

}  // namespace limn
