// SPDX-License-Identifier: MIT
#include "engine/solve/gauss_seidel.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/doo_sabin_rule.h"

namespace limn {

GaussSeidel::GaussSeidel(const SolveProblem& problem, absl::Span<Vec3> x)
    : mesh_(problem.mesh),
      stencil_(problem.stencil),
      points_(problem.points),
      length_(problem.scale),
      x_(x),
      centroids_(mesh_.face_count()) {}

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
    const LimitRow& row = stencil_.row(v);
    if (row.vertex == 1) {
      x_[v] = points_[v];
      continue;
    }
    const Vec3 move = (1 / Diagonal(v)) * (points_[v] - LimitPoint(v));
    x_[v] += move;
    *largest = std::max(*largest, length_.Square(move));
    for (Index i = mesh_.fan_begin()[v]; i < mesh_.fan_begin()[v + 1]; ++i) {
      const Index f = mesh_.face()[mesh_.fan()[i]];
      centroids_[f] += InverseArity(f) * move;
    }
  }
  *largest = std::sqrt(*largest);
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
    faces += stencil_.face_rule == FaceRule::kCentroid ? centroids_[mesh_.face()[h]] : Image(h);
    if (row.edges != 0) edges += x_[mesh_.vertex()[walk.Next(h)]];
  }
  const double valence = end - begin;
  return row.vertex * x_[v] + (row.faces / valence) * faces + (row.edges / valence) * edges;
}

// [ZC Eq. 1] word for word: the points of the face may change between any two images.
Vec3 GaussSeidel::Image(Index h) const {
  const Index first = mesh_.face_begin()[mesh_.face()[h]];
  const Index arity = mesh_.face_begin()[mesh_.face()[h] + 1] - first;
  Vec3 image = OwnWeight(arity) * x_[mesh_.vertex()[h]];
  for (Index d = 1; d < arity; ++d) {
    image += OtherWeight(d, arity) * x_[mesh_.vertex()[first + (h - first + d) % arity]];
  }
  return image;
}

double GaussSeidel::Diagonal(std::size_t v) const {
  const Index begin = mesh_.fan_begin()[v];
  const Index end = mesh_.fan_begin()[v + 1];
  double sum = 0;
  for (Index i = begin; i < end; ++i) {
    const Index f = mesh_.face()[mesh_.fan()[i]];
    sum += stencil_.face_rule == FaceRule::kCentroid
               ? InverseArity(f)
               : OwnWeight(mesh_.face_begin()[f + 1] - mesh_.face_begin()[f]);
  }
  const LimitRow& row = stencil_.row(v);
  return row.vertex + row.faces * sum / (end - begin);
}

double GaussSeidel::InverseArity(Index face) const {
  return 1.0 / (mesh_.face_begin()[face + 1] - mesh_.face_begin()[face]);
}

}  // namespace limn
