// SPDX-License-Identifier: MIT
#include "engine/limit/large_faces.h"

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/boundary_curve.h"

namespace limn {
namespace {

// Sides of the type-V face.
std::size_t VertexSides(const DooSabinSurface& surface, std::size_t v) {
  const HalfEdgeMesh& mesh = surface.mesh;
  const std::size_t m = mesh.valence(v);
  if (!mesh.IsBoundary(v)) return m;
  if (surface.boundary.sharp.empty()) return std::max<std::size_t>(4, 2 * m);
  return surface.boundary.SidesAt(surface.boundary.Find(mesh.vertex_half_edge()[v]), m);
}

Harmonics VertexHarmonics(const DooSabinSurface& surface, std::size_t v) {
  const HalfEdgeMesh& mesh = surface.mesh;
  const Index first = mesh.vertex_half_edge()[v];
  if (mesh.twin()[first] == kNoIndex) {
    BoundaryFace face;
    GatherBoundaryFace(mesh, surface.boundary, surface.corners.data(), surface.boundary.Find(first),
                       &face);
    return FirstHarmonics(face.point.size(), [&](std::size_t i) { return face.point[i]; });
  }
  const Index* const fan = mesh.fan().data() + mesh.fan_begin()[v];
  return FirstHarmonics(mesh.valence(v), [&](std::size_t i) { return surface.corners[fan[i]]; });
}

}  // namespace

absl::StatusOr<LargeFaces> LargeFaces::Find(const Context& context,
                                            const DooSabinSurface& surface) {
  LIMN_RETURN_IF_ERROR(context.Check());
  const HalfEdgeMesh& mesh = surface.mesh;
  LargeFaces found;
  found.vertex_count_ = mesh.vertex_count();
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (VertexSides(surface, v) < kLarge) continue;
    found.id_.push_back(v);
    for (std::size_t i = 0; i < mesh.valence(v); ++i) {
      found.place_.emplace_back(mesh.fan()[mesh.fan_begin()[v] + i], static_cast<Index>(i));
    }
  }
  std::sort(found.place_.begin(), found.place_.end());
  LIMN_RETURN_IF_ERROR(context.Check());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    if (mesh.face_begin()[f + 1] - mesh.face_begin()[f] < kLarge) continue;
    found.id_.push_back(found.vertex_count_ + f);
  }
  found.harmonics_.resize(found.id_.size());
  LIMN_RETURN_IF_ERROR(ParallelFor(
      context, found.id_.size(), std::size_t{16}, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const std::size_t id = found.id_[i];
          if (id < found.vertex_count_) {
            found.harmonics_[i] = VertexHarmonics(surface, id);
            continue;
          }
          const Index first = mesh.face_begin()[id - found.vertex_count_];
          const Index last = mesh.face_begin()[id - found.vertex_count_ + 1];
          found.harmonics_[i] = FirstHarmonics(
              last - first, [&](std::size_t j) { return surface.corners[first + j]; });
        }
      }));
  return found;
}

const Harmonics* LargeFaces::Of(std::size_t id) const {
  const auto at = std::lower_bound(id_.begin(), id_.end(), id);
  if (at == id_.end() || *at != id) return nullptr;
  return &harmonics_[static_cast<std::size_t>(at - id_.begin())];
}

std::size_t LargeFaces::PlaceInFan(Index h) const {
  return std::lower_bound(place_.begin(), place_.end(), std::pair<Index, Index>(h, 0))->second;
}

}  // namespace limn
