// SPDX-License-Identifier: MIT
// A Doo-Sabin surface, held by its first refined mesh M^1: all that refinement, limit points and
// exact evaluation start from.
#pragma once

#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/refine/boundary_curve.h"

namespace limn {

struct DooSabinSurface {
  // T^0, from HalfEdgeMesh::Build.
  HalfEdgeMesh mesh;
  // Points of M^1, one per half-edge of mesh, relative to boundary.origin (also for closed meshes).
  Buffer<Vec3> corners;
  // Along the boundary of mesh; without half-edges for closed meshes.
  BoundaryCurve boundary;

  const Vec3& origin() const { return boundary.origin; }
};

}  // namespace limn
