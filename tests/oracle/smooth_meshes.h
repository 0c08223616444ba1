// SPDX-License-Identifier: MIT
// Points of surfaces with closed forms.
#pragma once

#include "engine/mesh/polygon_mesh.h"

namespace limn::oracle {

// Quads on the torus around the z axis with the radii `ring` > `tube`.
PolygonMesh RoundTorus(int around, int across, double ring, double tube);

// The unit sphere: n x n quads on each side of a cube, their lines in equal angles.
PolygonMesh CubeSphere(int n);

}  // namespace limn::oracle
