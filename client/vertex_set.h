// SPDX-License-Identifier: MIT
// Sets of vertices for constraints, chosen by a condition of the caller.
#pragma once

#include <concepts>
#include <cstddef>
#include <functional>

#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/constraints.pb.h"

namespace limn {

// The vertices for which predicate(vertex, point) holds, ascending; it is called once for each, in
// order. For InterpolateHeader.constraints.interpolate: the surface passes through these, the
// others only shape it. Cost: one pass.
//
//   // Through the upper half only.
//   *header.mutable_constraints()->mutable_interpolate() =
//       limn::VerticesWhere(mesh, [](limn::Index, const limn::Vec3& p) { return p.z >= 0; });
template <std::predicate<Index, const Vec3&> Predicate>
[[nodiscard]] v1::VertexSet VerticesWhere(const PolygonMesh& mesh, Predicate predicate) {
  v1::VertexSet set;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const Index vertex = static_cast<Index>(v);
    if (std::invoke(predicate, vertex, mesh.positions[v])) set.add_vertices(vertex);
  }
  return set;
}

}  // namespace limn
