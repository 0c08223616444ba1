// SPDX-License-Identifier: MIT
// The numbering contract of engine/limit/tessellation.h, written from its words with maps.
#pragma once

#include <vector>

#include "tests/oracle/mesh.h"

namespace limn::oracle {

// Connectivity of T^k.
struct Tiling {
  int vertex_count = 0;
  std::vector<Face> faces;
};

// T^0: the vertices and faces of a mesh.
Tiling TilingOf(const Mesh& mesh);

// T^(k+1): vertices [vertices | edges in order of first occurrence | faces], one quad per corner in
// corner order: (vertex, edge leaving it, face, edge entering it).
Tiling Split(const Tiling& tiling);

// T^level of a mesh.
Tiling TilingAtLevel(const Mesh& mesh, int level);

// Vertices - edges + faces.
int EulerCharacteristic(const Tiling& tiling);

}  // namespace limn::oracle
