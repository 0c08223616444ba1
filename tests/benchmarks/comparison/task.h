// SPDX-License-Identifier: MIT
// What is compared: pieces of work that Limn and its peers each do in their own way, on the same
// mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::comparison {

enum class Task {
  // Index arrays -> connectivity.
  kBuild,
  // Connectivity and points -> control points, to 1e-6 and 1e-12 of the bounding box. What the
  // solver assembles, orders or factorises is included.
  kSolve6,
  kSolve12,
  // Connectivity and points -> those of one refinement.
  kDooSabinStep,
  kCatmullClarkStep,
  kLoopStep,
  // Index arrays and points -> connectivity and points of one refinement.
  kCatmullClark,
  kLoop,
  // Points -> points of one refinement, all else being there from before.
  kCatmullClarkPoints,
  kLoopPoints,
  // Index arrays and points -> limit points and normals at the vertices of one refinement.
  kCatmullClarkLimit,
  kLoopLimit,
};

struct TaskInfo {
  Task task;
  // For files and tables.
  const char* name;
  const char* title;
  bool triangles_only;
};
const std::vector<TaskInfo>& AllTasks();

enum class Meshes { kQuads, kTriangles, kPolygons };
const char* MeshesName(Meshes meshes);

// A closed mesh of about so many vertices. Throws what it cannot make.
PolygonMesh MakeMesh(Meshes meshes, std::uint64_t vertices);

// What a contestant found, for the check that all did the same work.
struct Answer {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;
  // Points are in the order of the given vertices, not in one of the contestant's own.
  bool in_order = false;
};

// Does a task over and over, in one thread unless it is told otherwise.
class Contestant {
 public:
  virtual ~Contestant() = default;
  // Not timed, before each Run: drops its last result, copies what it changes in place.
  virtual void Prepare() = 0;
  virtual void Run() = 0;
  virtual Answer GetAnswer() = 0;
};

struct Entry {
  std::string name;
  // What goals speak of, such as "direct"; empty for Limn itself.
  std::string rival;
  int threads = 1;
  // Answers agree with Limn's to this part of the bounding box (normals: of 1).
  double agreement = 1e-12;
  std::function<std::unique_ptr<Contestant>(const PolygonMesh& mesh)> make = {};
};

// Who takes part in a task. Limn with one and with two threads.
std::vector<Entry> LimnEntries(Task task);
std::vector<Entry> CgalEntries(Task task);
std::vector<Entry> OpenMeshEntries(Task task);
std::vector<Entry> OpenSubdivEntries(Task task);
std::vector<Entry> EigenEntries(Task task);
// All of them, Limn with one thread first.
std::vector<Entry> AllEntries(Task task);

// Control points to rounding, in the vertices' order.
Answer ExactSolution(const PolygonMesh& mesh);

}  // namespace limn::comparison
