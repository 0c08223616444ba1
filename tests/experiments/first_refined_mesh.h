// SPDX-License-Identifier: MIT
// The first refined mesh M^1 of a Doo-Sabin surface as a polygon mesh, to look at. The engine never
// builds its connectivity. Source: Zheng and Cai 2005, section 2, Fig. 1.
#pragma once

#include "engine/mesh/polygon_mesh.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn::experiments {

// Vertices: the corners of the given mesh, in order. Faces: one for each of its faces (type F),
// then for each of its edges (type E), then for each of its vertices (type V), in order and
// counter-clockwise. surface: of a closed mesh. Cost: linear.
PolygonMesh FirstRefinedMesh(const DooSabinSurface& surface);

}  // namespace limn::experiments
