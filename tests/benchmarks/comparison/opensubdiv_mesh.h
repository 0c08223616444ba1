// SPDX-License-Identifier: MIT
// A mesh in OpenSubdiv's terms.
#pragma once

#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <memory>
#include <stdexcept>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"
#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {

class OpenSubdivMesh {
 public:
  OpenSubdivMesh(const PolygonMesh& given, bool loop)
      : corners_(given.corner_vertex.begin(), given.corner_vertex.end()), loop_(loop) {
    for (std::size_t f = 0; f < given.face_count(); ++f) {
      arities_.push_back(static_cast<int>(given.arity(f)));
    }
    descriptor_.numVertices = static_cast<int>(given.vertex_count());
    descriptor_.numFaces = static_cast<int>(given.face_count());
    descriptor_.numVertsPerFace = arities_.data();
    descriptor_.vertIndicesPerFace = corners_.data();
  }
  OpenSubdivMesh(const OpenSubdivMesh&) = delete;
  OpenSubdivMesh& operator=(const OpenSubdivMesh&) = delete;

  // The connectivity of the mesh itself; nothing is refined yet.
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> MakeRefiner() const {
    OpenSubdiv::Sdc::Options options;
    options.SetVtxBoundaryInterpolation(OpenSubdiv::Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    const auto scheme = loop_ ? OpenSubdiv::Sdc::SCHEME_LOOP : OpenSubdiv::Sdc::SCHEME_CATMARK;
    std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner(
        OpenSubdiv::Far::TopologyRefinerFactory<OpenSubdiv::Far::TopologyDescriptor>::Create(
            descriptor_, {scheme, options}));
    if (refiner == nullptr) throw std::runtime_error("OpenSubdiv refuses the mesh");
    return refiner;
  }

 private:
  std::vector<int> arities_;
  std::vector<int> corners_;
  const bool loop_;
  OpenSubdiv::Far::TopologyDescriptor descriptor_;
};

inline Vec3 UnitNormal(const Vec3& u, const Vec3& v) {
  const Vec3 normal = Cross(u, v);
  const double length = Norm(normal);
  return length > 0 ? (1 / length) * normal : Vec3{0, 0, 0};
}

// The entries of bfr_side.cc.
void AddBfrEntries(bool loop, std::vector<Entry>* entries);

}  // namespace limn::comparison
