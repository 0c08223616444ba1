// SPDX-License-Identifier: MIT
// Doo-Sabin interpolation straight from the paper: Zheng and Cai, "Making Doo-Sabin surface
// interpolation always work over irregular meshes", The Visual Computer 2005. Closed meshes.
// Misprints put right: D in Eqs. 11 to 17 is I; step 4 of the listing means (I - W_c).
#pragma once

#include <array>
#include <vector>

#include "tests/oracle/dense.h"
#include "tests/oracle/mesh.h"
#include "tests/oracle/tessellation.h"

namespace limn::oracle {

// The matrix of Eq. 6. Its right side is 2 m_v I_v.
Matrix Equation6(const Mesh& mesh);

// Faces around each vertex: the m of Eq. 6.
std::vector<int> FacesAround(const Mesh& mesh);

// The auxiliary mesh's points: Eq. 6 solved for all vertices.
Points SolveEquation6(const Mesh& given);

// One sweep of Eq. 7: every V from the values before the sweep (Jacobi), or from the newest ones
// (Gauss-Seidel).
Points JacobiSweep(const Mesh& given, const Points& before);
Points GaussSeidelSweep(const Mesh& given, Points points);

// Images of a face's vertices by Eq. 1, and by Eq. 4.
Points Equation1(const Points& face);
Points Equation4(const Points& face);

// Eq. 10. Zero where the polygon has no area.
Point Equation10(const Points& face);

// The images W_1 ... W_m of one vertex moved by Eq. 17, so that their centroid is `target`.
Points Equation17(const Points& face, const Point& target);

// A mesh of any step, with edges of their own: two edges may join the same two vertices, as around
// the two-sided face of a vertex of valence 2.
struct DooSabinMesh {
  Points points;
  std::vector<Face> faces;
  // sides[f][i] is the edge from faces[f][i] to the next vertex of the face.
  std::vector<std::vector<int>> sides;
  // Vertex of T^k that each face of M^k, k >= 1, stands for.
  std::vector<int> tile_vertex;

  Points FacePoints(std::size_t face) const;
};

// M^0.
DooSabinMesh Start(const Mesh& mesh);

// M^1 by Eq. 4. tiling: T^0.
DooSabinMesh RefineFirst(const DooSabinMesh& mesh, const Tiling& tiling);

// M^(k+1) by Eq. 1 from M^k, k >= 1. tiling: T^k.
DooSabinMesh Refine(const DooSabinMesh& mesh, const Tiling& tiling);

// Moves the images of every given point by Eq. 17.
void Perturb(const Points& given, DooSabinMesh* first_refined);

// Face of T^k that each vertex of M^k, k >= 1, stands for: the one whose vertices stand for the
// faces around it; -1 for ghosts. tiling: T^k.
std::vector<int> TileOfVertex(const DooSabinMesh& mesh, const Tiling& tiling);

// The points of M^k in the order of the faces of T^k.
Points InTileOrder(const DooSabinMesh& mesh, const Tiling& tiling);

// Limit points of T^k: centroids of the faces of M^k.
Points LimitPoints(const DooSabinMesh& mesh, const Tiling& tiling);

// Normals of T^k: average normals of the faces that M^k's faces become after many refinements.
// Zero for faces that become a line or a point.
Points DeepNormals(const DooSabinMesh& mesh, const Tiling& tiling);
Point DeepNormal(const Points& face);

// All of it, as the engine's Interpolate does it, to T^level, level >= 1.
struct Interpolated {
  Points control;
  Tiling tiling;
  Points points;
  Points normals;
};
Interpolated InterpolateDooSabin(const Mesh& given, const Points& control, int level);

}  // namespace limn::oracle
