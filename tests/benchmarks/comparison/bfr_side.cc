// SPDX-License-Identifier: MIT
// OpenSubdiv's Bfr in the comparison: each face tessellated at rate 2, which gives the vertices of
// one refinement, with points and normals.
#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/bfr/tessellation.h>

#include <utility>

#include "engine/mesh/half_edge_mesh.h"
#include "tests/benchmarks/comparison/opensubdiv_mesh.h"
#include "tests/benchmarks/comparison/task.h"

namespace limn::comparison {
namespace {

namespace Bfr = OpenSubdiv::Bfr;

// Parameters of a face in the order corner 0, edge 0, corner 1, ..., middle.
using Parameters = std::vector<double>;

class BfrSide : public Contestant {
 public:
  // each_once: points that faces share are evaluated in one of them; otherwise, as tessellations by
  // faces do it, in each.
  BfrSide(const PolygonMesh& given, bool loop, bool each_once)
      : given_(given), mesh_(given, loop), each_once_(each_once), first_(2 * given.corner_count()) {
    const HalfEdgeMesh half_edges = HalfEdgeMesh::Build(Context(), given).value();
    for (const Index h : half_edges.vertex_half_edge()) first_[2 * h] = true;
    for (const Index h : half_edges.edge_half_edge()) first_[2 * h + 1] = true;
  }
  void Prepare() override { points_ = normals_ = std::vector<Vec3>(); }
  void Run() override {
    const auto refiner = mesh_.MakeRefiner();
    const Bfr::RefinerSurfaceFactory<> factory(*refiner);
    Bfr::Surface<double> surface;
    std::vector<double> patch;
    points_.reserve(2 * given_.corner_count() + given_.face_count());
    normals_.reserve(points_.capacity());
    for (std::size_t f = 0; f < given_.face_count(); ++f) {
      factory.InitVertexSurface(static_cast<int>(f), &surface);
      patch.resize(3 * static_cast<std::size_t>(surface.GetNumPatchPoints()));
      surface.PreparePatchPoints(&given_.positions[0].x, 3, patch.data(), 3);
      const Parameters& uv = ParametersOf(surface);
      for (std::size_t i = 0; 2 * i < uv.size(); ++i) {
        if (each_once_ && !IsFirst(f, i)) continue;
        Vec3 p;
        Vec3 u;
        Vec3 v;
        surface.Evaluate(&uv[2 * i], patch.data(), 3, &p.x, &u.x, &v.x);
        points_.push_back(p);
        normals_.push_back(UnitNormal(u, v));
      }
    }
  }
  Answer GetAnswer() override {
    if (each_once_) return {points_, normals_, false};
    Answer answer;
    std::size_t at = 0;
    for (std::size_t f = 0; f < given_.face_count(); ++f) {
      const std::size_t count = 2 * given_.arity(f) + (given_.arity(f) == 3 && triangles_ ? 0 : 1);
      for (std::size_t i = 0; i < count; ++i, ++at) {
        if (!IsFirst(f, i)) continue;
        answer.points.push_back(points_[at]);
        answer.normals.push_back(normals_[at]);
      }
    }
    return answer;
  }

 private:
  bool IsFirst(std::size_t f, std::size_t i) const {
    return i >= 2 * given_.arity(f) || first_[2 * std::size_t{given_.face_begin[f]} + i];
  }
  const Parameters& ParametersOf(const Bfr::Surface<double>& surface) {
    const Bfr::Parameterization parameterization = surface.GetParameterization();
    const auto arity = static_cast<std::size_t>(parameterization.GetFaceSize());
    if (arity >= by_arity_.size()) by_arity_.resize(arity + 1);
    Parameters& uv = by_arity_[arity];
    if (uv.empty()) {
      const Bfr::Tessellation tessellation(parameterization, 2);
      uv.resize(2 * static_cast<std::size_t>(tessellation.GetNumCoords()));
      tessellation.GetCoords(uv.data());
      if (arity == 3) triangles_ = uv.size() == 12;
    }
    return uv;
  }

  const PolygonMesh& given_;
  const OpenSubdivMesh mesh_;
  const bool each_once_;
  // Of the corners and edges of each face, whether no other face comes first.
  std::vector<bool> first_;
  std::vector<Parameters> by_arity_;
  // Triangles have no point in their middle.
  bool triangles_ = false;
  std::vector<Vec3> points_;
  std::vector<Vec3> normals_;
};

}  // namespace

void AddBfrEntries(bool loop, std::vector<Entry>* entries) {
  for (const bool each_once : {false, true}) {
    entries->push_back({.name = each_once ? "Bfr, each point once" : "Bfr, by faces",
                        .rival = each_once ? "Bfr once" : "Bfr",
                        .agreement = 1e-6,
                        .make = [=](const PolygonMesh& mesh) {
                          return std::make_unique<BfrSide>(mesh, loop, each_once);
                        }});
  }
}

}  // namespace limn::comparison
