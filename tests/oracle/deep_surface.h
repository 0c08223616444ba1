// SPDX-License-Identifier: MIT
// Doo-Sabin surfaces and their deep refinements: what exact evaluation is held against.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/limit/evaluate.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn::oracle {

// A surface over a mesh, open or closed, with the points of M^1 and those of the boundary curve at
// random places in [-1, 1]^3. (On the curve, a vertex that is no corner lies in the middle.)
DooSabinSurface RandomSurface(const PolygonMesh& given, std::uint64_t seed);
// The same with every other vertex of the boundary sharp.
DooSabinSurface RandomSharpSurface(const PolygonMesh& given, std::uint64_t seed);

// The surface that passes through the vertices of a mesh.
DooSabinSurface InterpolatingSurface(const PolygonMesh& given);

// The same surface by M^2 on T^1: patch h becomes 4h (at the vertex), 4h + 1 (edge), 4h + 2 (face)
// and 4h + 3 (the edge that enters).
DooSabinSurface RefinedSurface(const DooSabinSurface& surface);
// Where a parameter of T^0 lies on T^1; the first quarter of those that it borders on.
SurfaceParameter RefinedParameter(const DooSabinSurface& surface, const SurfaceParameter& p);

// The parameter (u, v) of the patch of half-edge h.
SurfaceParameter AtHalfEdge(const HalfEdgeMesh& mesh, Index h, double u, double v);

// Points and normals of T^level, level >= 1, as refinement and limit stencils give them, on a grid
// of cells + 1 by cells + 1 over every patch.
struct DeepSurface {
  std::size_t cells = 1;
  std::vector<Vec3> points;
  std::vector<Vec3> normals;
  // Vertex of T^level at u = i / cells, v = j / cells of patch h:
  // vertex[(h * (cells + 1) + j) * (cells + 1) + i].
  std::vector<Index> vertex;

  Index VertexAt(Index h, std::size_t i, std::size_t j) const {
    return vertex[(h * (cells + 1) + j) * (cells + 1) + i];
  }
  double At(std::size_t i) const { return static_cast<double>(i) / static_cast<double>(cells); }
};
DeepSurface Refined(const DooSabinSurface& surface, std::uint32_t level);

// All places of the grid.
struct GridParameters {
  std::vector<SurfaceParameter> parameters;
  // The vertex at each.
  std::vector<Index> vertices;
};
GridParameters AllOf(const DooSabinSurface& surface, const DeepSurface& deep);

// Random parameters everywhere, among them corners and sides of patches, and ones near them.
std::vector<SurfaceParameter> SomeParameters(const HalfEdgeMesh& mesh, std::size_t n,
                                             std::uint64_t seed);

// The deepest level, at most 8, with at most `most` quads.
std::uint32_t DeepLevel(const HalfEdgeMesh& mesh, std::size_t most);

// All four at all parameters; an error fails the test.
struct Samples {
  explicit Samples(std::size_t n) : points(n), du(n), dv(n), normals(n) {}
  std::vector<Vec3> points;
  std::vector<Vec3> du;
  std::vector<Vec3> dv;
  std::vector<Vec3> normals;
  SurfaceSamples Spans();
};
Samples Evaluated(const DooSabinSurface& surface, const std::vector<SurfaceParameter>& parameters);

}  // namespace limn::oracle
