// SPDX-License-Identifier: MIT
#include "engine/solve/gauss_seidel.h"

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {

GaussSeidel::GaussSeidel(const HalfEdgeMesh& mesh, const LimitStencil& stencil,
                         absl::Span<const Vec3> points, absl::Span<Vec3> x)
    : mesh_(mesh), stencil_(stencil), points_(points), x_(x), centroids_(mesh.face_count()) {}

absl::Status GaussSeidel::Sweep(const Context& context, double* largest) {
  // Anew in each sweep, so that rounding of the running updates does not build up.
  for (std::size_t f = 0; f < centroids_.size(); ++f) {
    if (f % kDefaultGrain == 0) LIMN_RETURN_IF_ERROR(context.Check());
    Vec3 sum = {0, 0, 0};
    for (Index h = mesh_.face_begin()[f]; h < mesh_.face_begin()[f + 1]; ++h) {
      sum += x_[mesh_.vertex()[h]];
    }
    centroids_[f] = InverseArity(static_cast<Index>(f)) * sum;
  }
  *largest = 0;
  for (std::size_t v = 0; v < x_.size(); ++v) {
    if (v % kDefaultGrain == 0) LIMN_RETURN_IF_ERROR(context.Check());
    const Vec3 move = (1 / Diagonal(v)) * (points_[v] - LimitPoint(v));
    x_[v] += move;
    *largest = std::max(*largest, MaxAbs(move));
    for (Index i = mesh_.fan_begin()[v]; i < mesh_.fan_begin()[v + 1]; ++i) {
      const Index f = mesh_.face()[mesh_.fan()[i]];
      centroids_[f] += InverseArity(f) * move;
    }
  }
  return absl::OkStatus();
}

Vec3 GaussSeidel::LimitPoint(std::size_t v) const {
  const LimitRow& row = stencil_.row(v);
  const Index begin = mesh_.fan_begin()[v];
  const Index end = mesh_.fan_begin()[v + 1];
  const PolygonWalk walk(mesh_);
  Vec3 faces = {0, 0, 0};
  Vec3 edges = {0, 0, 0};
  for (Index i = begin; i < end; ++i) {
    const Index h = mesh_.fan()[i];
    faces += centroids_[mesh_.face()[h]];
    if (row.edges != 0) edges += x_[mesh_.vertex()[walk.Next(h)]];
  }
  const double valence = end - begin;
  return row.vertex * x_[v] + (row.faces / valence) * faces + (row.edges / valence) * edges;
}

double GaussSeidel::Diagonal(std::size_t v) const {
  const Index begin = mesh_.fan_begin()[v];
  const Index end = mesh_.fan_begin()[v + 1];
  double sum = 0;
  for (Index i = begin; i < end; ++i) sum += InverseArity(mesh_.face()[mesh_.fan()[i]]);
  const LimitRow& row = stencil_.row(v);
  return row.vertex + row.faces * sum / (end - begin);
}

double GaussSeidel::InverseArity(Index face) const {
  return 1.0 / (mesh_.face_begin()[face + 1] - mesh_.face_begin()[face]);
}

}  // namespace limn
