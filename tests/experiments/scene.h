// SPDX-License-Identifier: MIT
// Meshes to look at: each is written as it is and, for the picture, once more with marks at tagged
// vertices and prescribed normals [ZC Fig. 6].
#pragma once

#include <string>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/limit/tessellation.h"
#include "engine/mesh/polygon_mesh.h"
#include "tests/experiments/experiment.h"

namespace limn::experiments {

struct Mark {
  Vec3 point = {0, 0, 0};
  // Unit length, or (0, 0, 0): none.
  Vec3 normal = {0, 0, 0};
};

// Writes NAME.obj, and scenes/NAME.obj with its materials, NAME.mtl. Marks are sized for models a
// few units long; they have normals if the surface has.
void WriteScene(const Setup& setup, const std::string& name, const PolygonMesh& mesh,
                const std::vector<Mark>& marks = {});
void WriteScene(const Setup& setup, const std::string& name, const Tessellation& surface,
                const std::vector<Mark>& marks = {});

}  // namespace limn::experiments
