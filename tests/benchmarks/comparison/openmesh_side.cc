// SPDX-License-Identifier: MIT
// OpenMesh in the comparison: add_face and the uniform subdividers.
// OpenMesh's vectors are uninitialised on purpose, and its subdividers shadow names.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/CatmullClarkT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>
#pragma GCC diagnostic pop

#include <stdexcept>

#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using PolyMesh = OpenMesh::PolyMesh_ArrayKernelT<Traits>;
using TriMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

template <class Mesh>
void BuildMesh(const PolygonMesh& given, Mesh* mesh) {
  mesh->reserve(given.vertex_count(), given.corner_count() / 2, given.face_count());
  for (const Vec3& p : given.positions) mesh->add_vertex({p.x, p.y, p.z});
  std::vector<OpenMesh::VertexHandle> face;
  for (std::size_t f = 0; f < given.face_count(); ++f) {
    face.clear();
    for (const Index v : given.face(f)) face.emplace_back(static_cast<int>(v));
    if (!mesh->add_face(face).is_valid()) throw std::runtime_error("OpenMesh: no face");
  }
}

// Subdivider: one refinement, or void.
template <class Mesh, class Subdivider>
class OpenMeshSide : public Contestant {
 public:
  OpenMeshSide(const PolygonMesh& given, bool from_arrays)
      : given_(given), from_arrays_(from_arrays) {
    if (!from_arrays) BuildMesh(given, &built_);
  }
  void Prepare() override { mesh_ = from_arrays_ ? Mesh() : built_; }
  void Run() override {
    if (from_arrays_) BuildMesh(given_, &mesh_);
    if constexpr (!std::is_void_v<Subdivider>) {
      Subdivider subdivider;
      subdivider.attach(mesh_);
      if (!subdivider(1)) throw std::runtime_error("OpenMesh: no refinement");
      subdivider.detach();
    }
  }
  Answer GetAnswer() override {
    Answer answer = {{}, {}, std::is_void_v<Subdivider>};
    for (const auto v : mesh_.vertices()) {
      const OpenMesh::Vec3d& p = mesh_.point(v);
      answer.points.push_back({p[0], p[1], p[2]});
    }
    return answer;
  }

 private:
  const PolygonMesh& given_;
  const bool from_arrays_;
  Mesh built_;
  Mesh mesh_;
};

using Build = OpenMeshSide<PolyMesh, void>;
using CatmullClark = OpenMeshSide<PolyMesh, OpenMesh::Subdivider::Uniform::CatmullClarkT<PolyMesh>>;
using Loop = OpenMeshSide<TriMesh, OpenMesh::Subdivider::Uniform::LoopT<TriMesh>>;

template <class Side>
std::vector<Entry> One(bool from_arrays) {
  return {{.name = "OpenMesh", .rival = "OpenMesh", .make = [=](const PolygonMesh& mesh) {
             return std::make_unique<Side>(mesh, from_arrays);
           }}};
}

}  // namespace

std::vector<Entry> OpenMeshEntries(Task task) {
  switch (task) {
    case Task::kBuild:
      return One<Build>(true);
    case Task::kCatmullClark:
      return One<CatmullClark>(true);
    case Task::kCatmullClarkStep:
      return One<CatmullClark>(false);
    case Task::kLoop:
      return One<Loop>(true);
    case Task::kLoopStep:
      return One<Loop>(false);
    default:
      return {};
  }
}

}  // namespace limn::comparison
