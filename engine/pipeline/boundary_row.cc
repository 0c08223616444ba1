// SPDX-License-Identifier: MIT
#include "engine/pipeline/boundary_row.h"

#include <algorithm>
#include <cmath>

namespace limn {
namespace {

// The weight of a vertex of the boundary in its own limit point: 2/3, more where it is sharp for a
// while, 1 for corners. What is sharp inside makes corners too.
class BoundaryRow {
 public:
  explicit BoundaryRow(const SurfaceLevel& level)
      : mesh_(level.mesh), sharpness_(level.sharpness) {}

  double WeightAt(Index v) const {
    if (!sharpness_.creased()) {
      const bool corner =
          sharpness_.boundary == BoundaryRule::kEdgeAndCorner && mesh_.valence(v) == 1;
      return corner ? 1 : kCubicCurve.vertex;
    }
    float most = sharpness_.vertex[v];
    for (Index i = mesh_.fan_begin()[v] + 1; i < mesh_.fan_begin()[v + 1]; ++i) {
      most = std::max(most, Edge(i));
    }
    if (most >= kSharpForever) return 1;
    double weight = kCubicCurve.vertex;
    for (int k = static_cast<int>(std::ceil(most)); k-- > 0;) {
      weight = 1 - (weight * NeighboursAfter(v, k) + (1 - weight) / 2);
    }
    return weight;
  }

 private:
  float Edge(Index i) const { return sharpness_.edge[mesh_.edge()[mesh_.fan()[i]]]; }
  static float After(float sharpness, int steps) {
    return std::max(0.0F, sharpness - static_cast<float>(steps));
  }

  // The share of both neighbours on the boundary in the vertex's point of T^(k+1): the rule is
  // asked what it makes of 0 and of ends at 1.
  double NeighboursAfter(Index v, int k) const {
    VertexBlend blend({0, 0, 0}, After(sharpness_.vertex[v], k));
    blend.Add(kSharpForever, {1, 0, 0});
    blend.Add(kSharpForever, {1, 0, 0});
    for (Index i = mesh_.fan_begin()[v] + 1; i < mesh_.fan_begin()[v + 1]; ++i) {
      blend.Add(After(Edge(i), k), {0, 0, 0});
    }
    return blend.Point({0, 0, 0}).x;
  }

  const HalfEdgeMesh& mesh_;
  const Sharpness& sharpness_;
};

}  // namespace

void SetBoundaryRows(const SurfaceLevel& level, BoundaryProblem* boundary) {
  const BoundaryRow row(level);
  const std::size_t size = boundary->curve.size();
  boundary->corner.resize(size);
  if (level.sharpness.transient > 0) boundary->vertex_weights.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double weight = row.WeightAt(level.mesh.vertex()[boundary->curve.half_edge[i]]);
    boundary->corner[i] = weight == 1 ? 1 : 0;
    if (!boundary->vertex_weights.empty()) boundary->vertex_weights[i] = weight;
  }
}

}  // namespace limn
