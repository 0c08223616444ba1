// SPDX-License-Identifier: MIT
// A closed mesh on which averages over faces mix as badly as they can: a regular map, all of whose
// vertices have valence 21 and all of whose faces have 21 sides, of genus 8042, with points that
// add up what a Chebyshev iteration of 17 sweeps leaves of each. Source: Coxeter and Moser,
// Generators and Relations for Discrete Groups, section 8.1 (maps as groups of rotations).
#pragma once

#include "engine/mesh/polygon_mesh.h"

namespace limn::oracle {

PolygonMesh RotationMap();

}  // namespace limn::oracle
