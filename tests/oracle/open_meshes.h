// SPDX-License-Identifier: MIT
// Open meshes to test with, made by code.
#pragma once

#include <string>
#include <vector>

#include "engine/mesh/polygon_mesh.h"

namespace limn::oracle {

// One face of n vertices on a circle, a little out of the plane.
PolygonMesh SinglePolygon(int n);
// width x height quads over a wave.
PolygonMesh QuadPatch(int width, int height);
// n triangles around an inner vertex; n triangles around a boundary vertex.
PolygonMesh TriangleFan(int n);
PolygonMesh HalfFan(int n);
// A tube of quads, with two boundary loops.
PolygonMesh OpenTube(int around, int along);

// Open meshes of at most 100 vertices, by name: boundary vertices of 1 to 6 faces, several loops
// and components, a single polygon, extraordinary vertices and faces near the boundary.
std::vector<std::string> OpenMeshNames();
PolygonMesh OpenMesh(const std::string& name);

}  // namespace limn::oracle
