// SPDX-License-Identifier: MIT
// What a mesh is like: counts, histograms, topology, and everything that is wrong with it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/polygon_mesh.h"
#include "engine/mesh/validate.h"

namespace limn {

// One kind of defect.
struct MeshProblem {
  Reason reason = Reason::kInternal;
  // Elements that have it.
  std::uint64_t count = 0;
  // The first of them: a vertex or a face, as the reason's nature is; for edges the first of the
  // faces around it.
  std::uint64_t first = 0;
  // For people, such as "2 vertices are used by no face; the first is vertex 17".
  std::string text;
};

struct MeshInfo {
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  std::uint64_t corners = 0;
  // Pairs of different vertices that are neighbours in a face.
  std::uint64_t edges = 0;
  // Number of faces by number of corners.
  std::map<std::uint64_t, std::uint64_t> arities;
  // Number of vertices by number of edges; isolated vertices count as 0.
  std::map<std::uint64_t, std::uint64_t> valences;
  // Edges of one face, and the closed curves that they form.
  std::uint64_t boundary_edges = 0;
  std::uint64_t boundary_loops = 0;
  // Parts that hang together by edges; isolated vertices are not counted.
  std::uint64_t components = 0;
  // Vertices in use - edges + faces.
  std::int64_t euler_characteristic = 0;
  // Sum of the components' genera, boundaries counted as if filled by disks. Only for oriented
  // manifolds.
  std::optional<std::int64_t> genus;
  // Of the finite positions.
  BoundingBox box;
  // In the order in which HalfEdgeMesh::Build looks for them; empty for a valid mesh, which may
  // have a boundary.
  std::vector<MeshProblem> problems;

  bool closed() const { return boundary_edges == 0; }
};

// Describes any mesh, also a broken one: faces that name missing vertices are counted but take no
// part in edges and topology, an edge from a vertex to itself is no edge. If face_begin is not what
// PolygonMesh promises, only vertices, corners, box and problems are filled in. Serial. Cost: sorts
// the edges; 60 bytes a corner. Throws std::bad_alloc. Thread-safe.
[[nodiscard]] MeshInfo DescribeMesh(const PolygonMesh& mesh);

}  // namespace limn
