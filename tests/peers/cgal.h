// SPDX-License-Identifier: MIT
// CGAL's refinements of a mesh of ours. Its headers are slow to compile and stay in cgal.cc.
#pragma once

#include <vector>

#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::peers {

enum class CgalScheme { kDooSabin, kCatmullClark, kLoop };

// The points after `levels` refinements, in CGAL's order. Throws when CGAL refuses the mesh.
std::vector<Vec3> CgalRefined(const PolygonMesh& mesh, CgalScheme scheme, int levels);

}  // namespace limn::peers
