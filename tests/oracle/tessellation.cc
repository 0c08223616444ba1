// SPDX-License-Identifier: MIT
#include "tests/oracle/tessellation.h"

#include <cstddef>

namespace limn::oracle {

Tiling TilingOf(const Mesh& mesh) { return {static_cast<int>(mesh.points.size()), mesh.faces}; }

Tiling Split(const Tiling& tiling) {
  const EdgeNumbers edges = NumberEdges(tiling.faces);
  const int first_edge = tiling.vertex_count;
  const int first_face = first_edge + static_cast<int>(edges.size());
  Tiling split;
  split.vertex_count = first_face + static_cast<int>(tiling.faces.size());
  for (std::size_t f = 0; f < tiling.faces.size(); ++f) {
    const Face& face = tiling.faces[f];
    const std::size_t m = face.size();
    for (std::size_t i = 0; i < m; ++i) {
      const int leaving = edges.at(EdgeKey(face[i], face[(i + 1) % m]));
      const int entering = edges.at(EdgeKey(face[(i + m - 1) % m], face[i]));
      split.faces.push_back(
          {face[i], first_edge + leaving, first_face + static_cast<int>(f), first_edge + entering});
    }
  }
  return split;
}

Tiling TilingAtLevel(const Mesh& mesh, int level) {
  Tiling tiling = TilingOf(mesh);
  for (int k = 0; k < level; ++k) tiling = Split(tiling);
  return tiling;
}

int EulerCharacteristic(const Tiling& tiling) {
  return tiling.vertex_count - static_cast<int>(NumberEdges(tiling.faces).size()) +
         static_cast<int>(tiling.faces.size());
}

}  // namespace limn::oracle
