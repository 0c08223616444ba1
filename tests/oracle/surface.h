// SPDX-License-Identifier: MIT
// Doo-Sabin surfaces to test with: the engine's stages up to M^1, for meshes known to be good.
#pragma once

#include <gtest/gtest.h>

#include "engine/constraints/perturb.h"
#include "engine/mesh/validate.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/doo_sabin_surface.h"
#include "engine/solve/solve.h"
#include "engine/stencil/limit_stencil.h"
#include "tests/oracle/expect.h"

namespace limn::oracle {

// M^1 of the surface that interpolates all vertices of a closed mesh.
inline DooSabinSurface SurfaceOf(const PolygonMesh& given) {
  const Context context;
  DooSabinSurface surface = {.mesh = BuildOrDie(given), .corners = {}, .boundary = {}};
  BoundingBox box;
  EXPECT_TRUE(ValidatePositions(context, given.positions, &box).ok());
  const LimitStencil stencil = DooSabinModifiedStencil();
  Buffer<Vec3> control(given.vertex_count());
  EXPECT_TRUE(Solve(context,
                    {.mesh = surface.mesh,
                     .stencil = stencil,
                     .points = given.positions,
                     .scale = box.diagonal() > 0 ? box.diagonal() : 1},
                    {}, absl::MakeSpan(control))
                  .ok());
  surface.corners.resize(surface.mesh.half_edge_count());
  EXPECT_TRUE(
      FirstRefinement(context, surface.mesh, control, absl::MakeSpan(surface.corners)).ok());
  EXPECT_TRUE(PerturbToInterpolate(context, {surface.mesh, given.positions},
                                   absl::MakeSpan(surface.corners))
                  .ok());
  return surface;
}

}  // namespace limn::oracle
