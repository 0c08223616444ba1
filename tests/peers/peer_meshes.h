// SPDX-License-Identifier: MIT
// The meshes that are compared: those made by code and, where the environment's LIMN_MESHES names a
// folder, the manifold ones of its files.
#pragma once

#include <string>
#include <vector>

#include "engine/mesh/polygon_mesh.h"

namespace limn::peers {

// Of `names`, those of at most 60 vertices (the larger ones are of kinds that are there in small
// too), and the folder's files.
std::vector<std::string> PeerMeshNames(std::vector<std::string> names);

// One of them by its name.
PolygonMesh PeerMesh(const std::string& name);

// It is one of the folder's.
bool IsFromFolder(const std::string& name);

// With what tests cannot be called by made '_'.
std::string TestName(std::string name);

}  // namespace limn::peers
