// SPDX-License-Identifier: MIT
// Catmull-Clark and Loop refinement from the textbooks, with semi-sharp creases, with maps and in
// long double. Sources: Catmull and Clark 1978; Loop 1987; DeRose, Kass and Truong 1998 (creases);
// OpenSubdiv's user guide (sharpness, its decay, and blending of rules).
#pragma once

#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tests/oracle/mesh.h"

namespace limn::oracle {

// What refinement does to the topology: quads for any faces, or triangles.
enum class Rule { kCatmullClark, kLoop };

// A mesh of any step, with edges of their own: two edges may join the same two vertices.
struct CreasedMesh {
  Points points;
  std::vector<Face> faces;
  // sides[f][i] is the edge from faces[f][i] to the next vertex of the face.
  std::vector<std::vector<int>> sides;
  // Ends of each edge.
  std::vector<std::pair<int, int>> edges;
  // Boundary edges count as infinitely sharp whatever stands here.
  std::vector<Real> edge_sharpness;
  std::vector<Real> vertex_sharpness;
  std::vector<bool> hole;
};

// Without creases; edges by NumberEdges.
CreasedMesh StartCreased(const Mesh& mesh);

// 10 and more never decays.
inline constexpr Real kForever = 10;

// The next step, numbered as in engine/limit/tessellation.h. blend: share of the bilinear rule in
// smooth points (Catmull-Clark).
CreasedMesh RefineCreased(const CreasedMesh& mesh, Rule rule, Real blend = 0);

// Edges and faces around each vertex, without order, and the faces at each edge.
struct Incidence {
  std::vector<std::vector<int>> edges_of_vertex;
  std::vector<std::vector<int>> faces_of_vertex;
  std::vector<std::vector<int>> faces_of_edge;
};
Incidence IncidenceOf(const CreasedMesh& mesh);

// Sharpness with boundaries taken into account.
Real SharpnessOf(const CreasedMesh& mesh, const Incidence& incidence, int edge);

// The end of an edge that is not v.
int OtherEnd(const CreasedMesh& mesh, int edge, int v);

// Some faces of a mesh, in their order, without the rest; `vertex` becomes vertex 0.
CreasedMesh PartOf(const CreasedMesh& mesh, const std::set<std::size_t>& kept, int vertex);

}  // namespace limn::oracle
