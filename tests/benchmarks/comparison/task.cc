// SPDX-License-Identifier: MIT
#include "tests/benchmarks/comparison/task.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "engine/mesh/generate.h"
#include "tests/oracle/test_meshes.h"

namespace limn::comparison {
namespace {

PolygonMesh Generated(MeshKind kind, std::uint64_t vertices) {
  absl::StatusOr<PolygonMesh> mesh =
      GenerateMesh({.kind = kind, .vertices = std::max(vertices, MinGeneratedVertices(kind))});
  if (!mesh.ok()) throw std::runtime_error(std::string(mesh.status().message()));
  return *std::move(mesh);
}

}  // namespace

const std::vector<TaskInfo>& AllTasks() {
  static const std::vector<TaskInfo> kTasks = {
      {Task::kBuild, "build", "Half-edge build from index arrays", false},
      {Task::kSolve6, "solve_1e-6", "Interpolation solved to 1e-6, assembly included", false},
      {Task::kSolve12, "solve_1e-12", "Interpolation solved to 1e-12, assembly included", false},
      {Task::kDooSabinStep, "doo_sabin_step", "Doo-Sabin step with connectivity", false},
      {Task::kCatmullClark, "catmull_clark", "Catmull-Clark from index arrays to refined points",
       false},
      {Task::kCatmullClarkStep, "catmull_clark_step", "Catmull-Clark step with connectivity",
       false},
      {Task::kCatmullClarkPoints, "catmull_clark_points",
       "Catmull-Clark points, all else kept from before", false},
      {Task::kLoop, "loop", "Loop from index arrays to refined points", true},
      {Task::kLoopStep, "loop_step", "Loop step with connectivity", true},
      {Task::kLoopPoints, "loop_points", "Loop points, all else kept from before", true},
      {Task::kCatmullClarkLimit, "catmull_clark_limit",
       "Catmull-Clark limit with normals, from index arrays", false},
      {Task::kLoopLimit, "loop_limit", "Loop limit with normals, from index arrays", true},
  };
  return kTasks;
}

const char* MeshesName(Meshes meshes) {
  switch (meshes) {
    case Meshes::kQuads:
      return "quads";
    case Meshes::kTriangles:
      return "triangles";
    default:
      return "polygons";
  }
}

PolygonMesh MakeMesh(Meshes meshes, std::uint64_t vertices) {
  switch (meshes) {
    case Meshes::kQuads:
      return Generated(MeshKind::kCube, vertices);
    case Meshes::kTriangles: {
      // Each face gets a vertex in its middle, so a smaller mesh is cut.
      const PolygonMesh trial =
          Generated(MeshKind::kIrregularSphere, std::min<std::uint64_t>(vertices, 10'000));
      const double growth = static_cast<double>(oracle::Triangulated(trial).vertex_count()) /
                            static_cast<double>(trial.vertex_count());
      return oracle::Triangulated(
          Generated(MeshKind::kIrregularSphere,
                    static_cast<std::uint64_t>(static_cast<double>(vertices) / growth)));
    }
    default:
      return Generated(MeshKind::kIrregularSphere, vertices);
  }
}

std::vector<Entry> AllEntries(Task task) {
  std::vector<Entry> all = LimnEntries(task);
  for (auto* peer : {CgalEntries, OpenMeshEntries, OpenSubdivEntries, EigenEntries}) {
    for (Entry& entry : peer(task)) all.push_back(std::move(entry));
  }
  return all;
}

}  // namespace limn::comparison
