// SPDX-License-Identifier: MIT
// CGAL in the comparison: Surface_mesh and Subdivision_method_3.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/subdivision_method_3.h>

#include <stdexcept>

#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

Mesh BuildMesh(const PolygonMesh& given) {
  Mesh mesh;
  const auto vertices = static_cast<Mesh::size_type>(given.vertex_count());
  mesh.reserve(vertices, static_cast<Mesh::size_type>(given.corner_count() / 2),
               static_cast<Mesh::size_type>(given.face_count()));
  for (const Vec3& p : given.positions) mesh.add_vertex({p.x, p.y, p.z});
  std::vector<Mesh::Vertex_index> face;
  for (std::size_t f = 0; f < given.face_count(); ++f) {
    face.clear();
    for (const Index v : given.face(f)) face.emplace_back(v);
    if (mesh.add_face(face) == Mesh::null_face()) throw std::runtime_error("CGAL: no face");
  }
  return mesh;
}

class Cgal : public Contestant {
 public:
  Cgal(const PolygonMesh& given, Task task) : given_(given), task_(task) {
    from_arrays_ = task == Task::kBuild || task == Task::kCatmullClark || task == Task::kLoop;
    if (!from_arrays_) built_ = BuildMesh(given);
  }
  void Prepare() override { mesh_ = from_arrays_ ? Mesh() : built_; }
  void Run() override {
    if (from_arrays_) mesh_ = BuildMesh(given_);
    const auto once = CGAL::parameters::number_of_iterations(1);
    switch (task_) {
      case Task::kBuild:
        break;
      case Task::kDooSabinStep:
        CGAL::Subdivision_method_3::DooSabin_subdivision(mesh_, once);
        break;
      case Task::kCatmullClark:
      case Task::kCatmullClarkStep:
        CGAL::Subdivision_method_3::CatmullClark_subdivision(mesh_, once);
        break;
      default:
        CGAL::Subdivision_method_3::Loop_subdivision(mesh_, once);
    }
  }
  Answer GetAnswer() override {
    Answer answer = {{}, {}, task_ == Task::kBuild};
    for (const Mesh::Vertex_index v : mesh_.vertices()) {
      const Kernel::Point_3& p = mesh_.point(v);
      answer.points.push_back({p.x(), p.y(), p.z()});
    }
    return answer;
  }

 private:
  const PolygonMesh& given_;
  const Task task_;
  bool from_arrays_;
  Mesh built_;
  Mesh mesh_;
};

}  // namespace

std::vector<Entry> CgalEntries(Task task) {
  switch (task) {
    case Task::kBuild:
    case Task::kDooSabinStep:
    case Task::kCatmullClark:
    case Task::kCatmullClarkStep:
    case Task::kLoop:
    case Task::kLoopStep:
      return {{.name = "CGAL", .rival = "CGAL", .make = [task](const PolygonMesh& mesh) {
                 return std::make_unique<Cgal>(mesh, task);
               }}};
    default:
      return {};
  }
}

}  // namespace limn::comparison
