// SPDX-License-Identifier: MIT
// Limits of Catmull-Clark and Loop surfaces at a vertex by nothing but many refinements of what is
// around it. After each of them the ring is moved to the origin and scaled up again, so that its
// shape keeps all digits however small it becomes.
#pragma once

#include <vector>

#include "tests/oracle/creased.h"

namespace limn::oracle {

struct DeepLimit {
  Point point;
  // The ring after the last refinement, as differences to the vertex and scaled: ends of the edges,
  // counter-clockwise, the first one sharp if any is; whether each edge is sharp; at a boundary
  // from one end to the other.
  Points ring;
  // The vertices across the faces between them: at quads the fourth, at triangles those of E_i.
  Points across;
  std::vector<bool> sharp;
  bool closed = true;
  // Mean over the parts between sharp edges of the mean of the normals of their first and last
  // triangle (V, E_i, E_(i+1)); at smooth vertices, darts, and corners without sharp edges the
  // direction of the vector area of the faces.
  Point normal;
};

// Creases must be sharp forever.
DeepLimit RefineDeeply(const CreasedMesh& mesh, Rule rule, int vertex, int steps);

}  // namespace limn::oracle
