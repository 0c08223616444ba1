// SPDX-License-Identifier: MIT
// The tessellated limit surface and its numbering contract, the same for every scheme.
//
// Level 0 has the input's vertices and faces. Each level splits every face of arity m into m
// quads (Loop: triangles into four) and numbers its vertices as
//   [vertices of the level before | its edges | its faces]   (Loop: without faces),
// edges in the order of their first occurrence when corners are walked face by face. Level k has
// one quad per corner of level k - 1, in corner order:
//   (vertex, edge leaving it, face, edge entering it).
// Loop: triangle f of level k - 1 becomes triangles 4f .. 4f + 3, one for each of its corners in
// corner order,
//   (vertex, edge leaving it, edge entering it),
// and then the middle one, (edge leaving its first corner, its second, its third).
// So the first n vertices of every level are the limit points of the n input vertices, in input
// order, and the connectivity is a function of the input's connectivity and the level alone.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/base/buffer.h"
#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

struct Tessellation {
  std::uint32_t level = 0;
  // Points of the limit surface, in model units.
  Buffer<Vec3> positions;
  // Unit normals of the limit surface, outward for counter-clockwise faces; (0, 0, 0) where the
  // surface has no tangent plane. Empty when not asked for.
  Buffer<Vec3> normals;
  // Sides of every face, or 0 when they differ (level 0): then face_begin says where faces begin.
  std::uint32_t arity = 0;
  // As in PolygonMesh. Empty unless arity is 0.
  Buffer<Index> face_begin;
  // Vertices of the faces, counter-clockwise.
  Buffer<Index> face_vertices;

  std::size_t vertex_count() const { return positions.size(); }
  std::size_t face_count() const {
    if (arity != 0) return face_vertices.size() / arity;
    return face_begin.empty() ? 0 : face_begin.size() - 1;
  }
};

}  // namespace limn
