// SPDX-License-Identifier: MIT
#include "tests/peers/cgal.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/subdivision_method_3.h>

#include <stdexcept>

namespace limn::peers {

std::vector<Vec3> CgalRefined(const PolygonMesh& mesh, CgalScheme scheme, int levels) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  Mesh refined;
  for (const Vec3& p : mesh.positions) refined.add_vertex({p.x, p.y, p.z});
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<Mesh::Vertex_index> face;
    for (const Index v : mesh.face(f)) face.emplace_back(v);
    if (refined.add_face(face) == Mesh::null_face()) throw std::runtime_error("CGAL: no face");
  }
  const auto iterations = CGAL::parameters::number_of_iterations(static_cast<unsigned>(levels));
  switch (scheme) {
    case CgalScheme::kDooSabin:
      CGAL::Subdivision_method_3::DooSabin_subdivision(refined, iterations);
      break;
    case CgalScheme::kCatmullClark:
      CGAL::Subdivision_method_3::CatmullClark_subdivision(refined, iterations);
      break;
    case CgalScheme::kLoop:
      CGAL::Subdivision_method_3::Loop_subdivision(refined, iterations);
      break;
  }
  std::vector<Vec3> points;
  for (const Mesh::Vertex_index v : refined.vertices()) {
    const Kernel::Point_3& p = refined.point(v);
    points.push_back({p.x(), p.y(), p.z()});
  }
  return points;
}

}  // namespace limn::peers
