// SPDX-License-Identifier: MIT
// The examples of Xu and Kondo, "Introducing feature values for effective specification of
// polyhedral networks", section 4; each writes meshes and adds its part to the report.
#pragma once

#include <string>
#include <vector>

#include "engine/constraints/feature_values.h"
#include "engine/interpolate.h"
#include "tests/experiments/experiment.h"
#include "tests/experiments/report.h"

namespace limn::experiments {

// Fig. 8: a cube with growing EFV, and with two sharp vertices.
void RunCube(const Setup& setup, Report* report);
// Figs. 9 to 11: a club by Doo-Sabin alone, by feature values, and with a plane face.
void RunClub(const Setup& setup, Report* report);
// Fig. 12: a tube under three loads. The values follow from a simulated pressure (the paper's
// future work 1).
void RunTube(const Setup& setup, Report* report);

// A surface with its patches, without normals: the pictures show facets.
InterpolateResult Shape(const Setup& setup, const PolygonMesh& mesh, const FeatureValues& values,
                        std::uint32_t level);
// The surface of plain Doo-Sabin refinement, whose control mesh is the given one.
InterpolateResult Plain(const Setup& setup, const PolygonMesh& mesh, std::uint32_t level);

// Volume inside a closed surface of quads.
double VolumeOf(const Tessellation& surface);

// Surfaces side by side along x, each moved by `step` from the one before: a picture of its own.
struct Row {
  std::vector<Tessellation> surfaces;
  Vec3 step = {0, 0, 0};
};
PolygonMesh SideBySide(const Row& row);

}  // namespace limn::experiments
