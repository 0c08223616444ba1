// SPDX-License-Identifier: MIT
// All tessellations of a surface up to a level, and their triangles.
#pragma once

#include <random>
#include <vector>

#include "engine/limit/tessellation.h"
#include "engine/refine/doo_sabin_surface.h"
#include "tests/oracle/triangle_tree.h"

namespace limn::oracle {

// T^0 .. T^finest of M^1, by the engine, without normals. Positions are relative to the origin of
// the surface.
std::vector<Tessellation> TessellationsOf(const DooSabinSurface& surface, int finest);

// Its faces as triangles: fans around a corner of each that is drawn.
std::vector<Triangle> SplitAtRandom(const Tessellation& surface, std::mt19937_64* random);

}  // namespace limn::oracle
