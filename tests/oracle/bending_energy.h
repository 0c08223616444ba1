// SPDX-License-Identifier: MIT
// The integral of H^2 over a closed Doo-Sabin surface by brute force: deep refinement, all patches
// whose four faces are quads; what is left around extraordinary points is left out.
#pragma once

#include "absl/types/span.h"
#include "tests/oracle/doo_sabin.h"

namespace limn::oracle {

// given: the mesh whose T^0 it is. corners: points of M^1 in the order of its corners. The patches
// of M^level are summed up.
Real BendingEnergy(const Mesh& given, absl::Span<const Vec3> corners, int level);

}  // namespace limn::oracle
