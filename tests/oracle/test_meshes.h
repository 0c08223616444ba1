// SPDX-License-Identifier: MIT
// Meshes to test with, made by code: closed ones of every kind, and one broken mesh per kind of
// error.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <set>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::oracle {

PolygonMesh MakeMesh(std::initializer_list<Vec3> positions,
                     std::initializer_list<std::initializer_list<Index>> faces);

PolygonMesh Tetrahedron();
PolygonMesh Cube();
PolygonMesh Octahedron();
PolygonMesh Dodecahedron();
// Two n-gons joined by quads, by triangles; n triangles up and n down, whose first vertex, the hub,
// has valence n.
PolygonMesh Prism(int n);
PolygonMesh Antiprism(int n);
PolygonMesh DoublePyramid(int n);
// Around the ring and around the tube, at least 3 each.
PolygonMesh TorusOfQuads(int around, int across);
PolygonMesh TorusOfTriangles(int around, int across);
// The boundary of a set of unit cubes, quads facing outwards. Not manifold where cubes touch at an
// edge or a vertex only.
PolygonMesh CubesSurface(const std::set<std::array<int, 3>>& cubes);
// A tetrahedron and, apart from it, a cube.
PolygonMesh TwoComponents();
// The surface of a plate of unit cubes with three holes.
PolygonMesh GenusThree();
// A cube with one more vertex on an edge, a little off it: a vertex of two faces.
PolygonMesh CubeWithVertexOfValenceTwo();
// Two n-gons back to back: every vertex has two faces.
PolygonMesh Pillow(int n);

// Moves every vertex by up to `amount` per coordinate: faces are no longer planar.
PolygonMesh Jittered(PolygonMesh mesh, std::uint64_t seed, double amount);
// The points scaled by a factor and then moved.
PolygonMesh Moved(PolygonMesh mesh, double factor, const Vec3& offset);
// Corners, faces and vertices renumbered at random.
PolygonMesh Shuffled(const PolygonMesh& mesh, std::uint64_t seed);
// Faces that are not triangles are cut into some, around a new vertex in their middle.
PolygonMesh Triangulated(const PolygonMesh& mesh);

// Closed meshes of at most 400 vertices, by name; the seeds of random ones are in their names.
std::vector<std::string> ClosedMeshNames();
PolygonMesh ClosedMesh(const std::string& name);

// What HalfEdgeMesh::Build must refuse, and how.
struct BrokenMesh {
  std::string name;
  PolygonMesh mesh;
  Reason reason;
  // Field of the error, how many elements are wrong, and the first of them.
  std::string field;
  std::uint64_t count;
  std::uint64_t first;
};
std::vector<BrokenMesh> BrokenMeshes();

}  // namespace limn::oracle
