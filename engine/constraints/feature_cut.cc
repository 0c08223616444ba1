// SPDX-License-Identifier: MIT
#include "engine/constraints/feature_cut.h"

#include <cstddef>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {
namespace {

// Gives each run of corners around a vertex its number.
class Cutter {
 public:
  Cutter(const HalfEdgeMesh& mesh, absl::Span<const std::uint8_t> plane)
      : mesh_(mesh), plane_(plane) {}

  absl::StatusOr<HalfEdgeMesh> Run(const Context& context) {
    PolygonMesh cut;
    cut.face_begin.assign(mesh_.face_begin().begin(), mesh_.face_begin().end());
    cut.corner_vertex.assign(mesh_.vertex().begin(), mesh_.vertex().end());
    std::size_t vertices = mesh_.vertex_count();
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context, mesh_.vertex_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) {
            CutVertex(static_cast<Index>(v), &cut.corner_vertex, &vertices);
          }
        }));
    // Nobody looks at them but at their number.
    cut.positions.resize(vertices);
    return HalfEdgeMesh::Build(context, cut);
  }

 private:
  bool IsCut(Index h) const {
    const Index twin = mesh_.twin()[h];
    return plane_[mesh_.face()[h]] != 0 || (twin != kNoIndex && plane_[mesh_.face()[twin]] != 0);
  }

  void CutVertex(Index v, Buffer<Index>* corner_vertex, std::size_t* vertices) const {
    const absl::Span<const Index> fan = mesh_.fan().subspan(mesh_.fan_begin()[v], mesh_.valence(v));
    // A run begins with the half-edge that leaves along a cut, or along the boundary.
    std::size_t first = 0;
    if (!mesh_.IsBoundary(v)) {
      while (first < fan.size() && !IsCut(fan[first])) ++first;
      if (first == fan.size()) return;
    }
    Index number = v;
    for (std::size_t i = 0; i < fan.size(); ++i) {
      const Index h = fan[(first + i) % fan.size()];
      if (i > 0 && IsCut(h)) {
        number = static_cast<Index>((*vertices)++);
      }
      (*corner_vertex)[h] = number;
    }
  }

  const HalfEdgeMesh& mesh_;
  const absl::Span<const std::uint8_t> plane_;
};

}  // namespace

absl::StatusOr<HalfEdgeMesh> CutAlongPlanes(const Context& context, const HalfEdgeMesh& mesh,
                                            absl::Span<const std::uint8_t> plane) {
  return Cutter(mesh, plane).Run(context);
}

}  // namespace limn
