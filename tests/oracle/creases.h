// SPDX-License-Identifier: MIT
// Creases, corners and holes to test with, and what the oracle makes of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/mesh/polygon_mesh.h"
#include "engine/scheme/sharpness.h"
#include "tests/oracle/creased.h"

namespace limn::oracle {

// The lists of a CreaseInput, owned.
struct Creases {
  std::vector<Index> indices;
  std::vector<Index> lengths;
  std::vector<float> sharpnesses;
  std::vector<Index> corners;
  std::vector<float> corner_sharpnesses;
  std::vector<Index> holes;
  BoundaryRule boundary = BoundaryRule::kEdgeAndCorner;

  CreaseInput input() const {
    return {indices, lengths, sharpnesses, corners, corner_sharpnesses, holes, boundary};
  }
};

// A crease of one sharpness along a path of edges, found from the seed; it does not touch itself.
void AddCrease(const PolygonMesh& mesh, std::uint64_t seed, float sharpness, Creases* creases);

// Some creases of the sharpnesses 0.3, 1, 2.7 and 10, some of them crossing, a few corners and a
// hole.
Creases RandomCreases(const PolygonMesh& mesh, std::uint64_t seed);

// The oracle's mesh with these creases, with corners of the boundary sharpened by the rule.
CreasedMesh WithCreases(const Mesh& mesh, const Creases& creases);

}  // namespace limn::oracle
