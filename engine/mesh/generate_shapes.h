// SPDX-License-Identifier: MIT
// One function per kind of generated mesh; see generate.h. `vertices` is in the kind's range.
#pragma once

#include <cstdint>

#include "engine/mesh/generate_random.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::generate {

PolygonMesh IrregularSphere(std::uint64_t vertices, Random* random);
PolygonMesh Torus(std::uint64_t vertices, Random* random);
PolygonMesh HighGenus(std::uint64_t vertices, Random* random);
PolygonMesh Hub(std::uint64_t vertices, Random* random);
PolygonMesh Ngons(std::uint64_t vertices, Random* random);
PolygonMesh Cube(std::uint64_t vertices, Random* random);
PolygonMesh Grid(std::uint64_t vertices, Random* random);
PolygonMesh Disk(std::uint64_t vertices, Random* random);
PolygonMesh GradedBox(std::uint64_t vertices, Random* random);

}  // namespace limn::generate
