// SPDX-License-Identifier: MIT
// What a repaired mesh must be, found out from the input with lists and maps.
#pragma once

#include <cstddef>

#include "engine/mesh/polygon_mesh.h"
#include "engine/mesh/repair.h"

namespace limn::oracle {

// Holds a mesh that was repaired with all options on against every promise of repair.h but those
// about threads, time and the choice among pairs; GoogleTest failures say which is broken. Indices
// of `input` must be in range. Slow: small meshes only.
void ExpectRepaired(const PolygonMesh& input, const RepairedMesh& repaired);

// Sides of the mesh that no other face shares.
std::size_t BoundarySides(const PolygonMesh& mesh);

}  // namespace limn::oracle
