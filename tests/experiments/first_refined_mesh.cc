// SPDX-License-Identifier: MIT
#include "tests/experiments/first_refined_mesh.h"

#include <cstddef>

namespace limn::experiments {

PolygonMesh FirstRefinedMesh(const DooSabinSurface& surface) {
  const HalfEdgeMesh& given = surface.mesh;
  const PolygonWalk walk(given);
  PolygonMesh mesh;
  for (const Vec3& corner : surface.corners) mesh.positions.push_back(surface.origin() + corner);
  Buffer<Index> face;
  for (Index f = 0; f < given.face_count(); ++f) {
    face.clear();
    for (Index h = walk.FaceBegin(f); h < walk.FaceEnd(f); ++h) face.push_back(h);
    mesh.AddFace(face);
  }
  for (const Index h : given.edge_half_edge()) {
    const Index t = given.twin()[h];
    mesh.AddFace({walk.Next(h), h, walk.Next(t), t});
  }
  for (std::size_t v = 0; v < given.vertex_count(); ++v) {
    mesh.AddFace(given.fan().subspan(given.fan_begin()[v], given.valence(v)));
  }
  return mesh;
}

}  // namespace limn::experiments
