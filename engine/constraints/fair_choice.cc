// SPDX-License-Identifier: MIT
#include "engine/constraints/fair_choice.h"

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

absl::Status FairChoice::Measure(const Context& context, absl::Span<const double> patches) {
  const HalfEdgeMesh& mesh = faces_.mesh();
  face_.resize(mesh.face_count());
  return ParallelFor(context, face_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      double sum = 0;
      const std::size_t last = std::size_t{4} * mesh.face_begin()[f + 1];
      for (std::size_t i = std::size_t{4} * mesh.face_begin()[f]; i < last; ++i) sum += patches[i];
      face_[f] = sum;
    }
  });
}

double FairChoice::EnergyAround(std::size_t v) const {
  const PolygonWalk walk(faces_.mesh());
  double sum = 0;
  for (const Index h : faces_.Fan(v)) sum += face_[walk.Face(h)];
  return sum;
}

absl::Status FairChoice::Consider(const Context& context, const MeasuredCorners& shape) {
  LIMN_RETURN_IF_ERROR(Measure(context, shape.patches));
  const std::size_t n = faces_.vertex_count();
  const bool first = least_.empty();
  corners_.resize(shape.corners.size());
  least_.resize(n);
  cures_.resize(n);
  return ParallelFor(context, n, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const double energy = EnergyAround(v);
      if (!first && !(energy < least_[v])) continue;
      least_[v] = energy;
      cures_[v] = shape.cures;
      for (const Index h : faces_.Fan(v)) corners_[h] = shape.corners[h];
    }
  });
}

absl::Status FairChoice::Renew(const Context& context, absl::Span<const double> patches) {
  LIMN_RETURN_IF_ERROR(Measure(context, patches));
  return ParallelFor(context, least_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) least_[v] = EnergyAround(v);
  });
}

FairCures FairChoice::cures() const {
  FairCures all;
  for (const FairCures& some : cures_) {
    all.shape_handles = all.shape_handles || some.shape_handles;
    all.smoothing = all.smoothing || some.smoothing;
  }
  return all;
}

}  // namespace limn
