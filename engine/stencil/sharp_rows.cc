// SPDX-License-Identifier: MIT
#include "engine/stencil/sharp_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/loop_refine.h"

namespace limn {
namespace {

// Weights of a ring's points, and what is sharp in it; used again for one vertex after the other.
class RingRow {
 public:
  RingRow(RingKind kind, double bilinear) : quads_(kind == RingKind::kQuads), bilinear_(bilinear) {}

  // Starts with the ring of T^0 around a vertex of valence n.
  void Start(std::size_t n, float vertex_sharpness) {
    vertex_sharpness_ = vertex_sharpness;
    edge_sharpness_.clear();
    edge_.assign(n, 0);
    face_.assign(n, 0);
    centroid_.assign(n, 0);
    next_edge_.assign(n, 0);
  }
  void AddEdge(float sharpness) { edge_sharpness_.push_back(sharpness); }

  // The limit point in terms of the ring of T^0: weights of the ends of edges and of the centroids
  // of faces, by edge and face.
  void Find() {
    const int steps = Steps();
    TakeMask(steps);
    for (int k = steps; k-- > 0;) {
      TakeBack(k);
      if (k > 0) SpreadCentroids();
    }
    // Quads: at least one step has been taken back. Triangles have no faces.
  }
  double edge(std::size_t i) const { return edge_[i]; }
  double face(std::size_t i) const { return quads_ ? centroid_[i] : 0; }

 private:
  std::size_t size() const { return edge_.size(); }
  std::size_t Before(std::size_t i) const { return i == 0 ? size() - 1 : i - 1; }
  std::size_t After(std::size_t i) const { return i + 1 == size() ? 0 : i + 1; }

  static float SharpnessAfter(float sharpness, int steps) {
    return sharpness >= kSharpForever ? sharpness
                                      : std::max(0.0F, sharpness - static_cast<float>(steps));
  }

  // Refinements until nothing wears off; for quads one at least, which makes all faces quads.
  int Steps() const {
    float most = quads_ ? 1 : 0;
    const auto see = [&](float s) {
      if (s < kSharpForever) most = std::max(most, s);
    };
    see(vertex_sharpness_);
    for (const float s : edge_sharpness_) see(s);
    return static_cast<int>(std::ceil(most));
  }

  // The mask of what is sharp for ever, on the ring of T^steps.
  void TakeMask(int steps) {
    const RingKind kind = quads_ ? RingKind::kQuads : RingKind::kTriangles;
    std::size_t sharp = 0;
    std::size_t first = 0;
    for (std::size_t i = size(); i-- > 0;) {
      if (SharpnessAfter(edge_sharpness_[i], steps) <= 0) continue;
      ++sharp;
      first = i;
    }
    switch (RuleOf(SharpnessAfter(vertex_sharpness_, steps), sharp)) {
      case VertexRule::kSmooth: {
        const PointMask mask = SmoothPointMask(kind, size());
        std::fill(edge_.begin(), edge_.end(), mask.edge);
        std::fill(face_.begin(), face_.end(), mask.face);
        return;
      }
      case VertexRule::kDart: {
        const DartMask mask = DartPointMask(kind, size());
        for (std::size_t i = 0; i < size(); ++i) {
          edge_[(first + i) % size()] = mask.edge[i];
          if (quads_) face_[(first + i) % size()] = mask.face[i];
        }
        return;
      }
      case VertexRule::kCrease:
        for (std::size_t i = 0; i < size(); ++i) {
          if (SharpnessAfter(edge_sharpness_[i], steps) > 0) edge_[i] = 1 / 6.0;
        }
        return;
      case VertexRule::kCorner:
        return;
    }
  }

  // From the ring of T^(k+1) to that of T^k, with the centroids of its faces instead of the F_i.
  // The weight of V is what is left to 1.
  void TakeBack(int k) {
    const double smooth_share = k == 0 ? 1 - bilinear_ : 1;
    double own = 1;
    for (std::size_t i = 0; i < size(); ++i) own -= edge_[i] + face_[i];
    std::swap(edge_, next_edge_);
    std::fill(edge_.begin(), edge_.end(), 0.0);
    std::copy(face_.begin(), face_.end(), centroid_.begin());
    TakeBackVertex(own, k, smooth_share);
    for (std::size_t i = 0; i < size(); ++i) {
      const double weight = next_edge_[i];
      const double smooth =
          smooth_share * (1 - std::min(1.0F, SharpnessAfter(edge_sharpness_[i], k))) * weight;
      if (quads_) {
        edge_[i] += 0.5 * weight - 0.25 * smooth;
        centroid_[i] += 0.25 * smooth;
        centroid_[Before(i)] += 0.25 * smooth;
      } else {
        edge_[i] += 0.5 * weight - 0.125 * smooth;
        edge_[Before(i)] += 0.125 * smooth;
        edge_[After(i)] += 0.125 * smooth;
      }
    }
  }

  // The rule of the vertex is linear: it is asked what it makes of V = (0, 1, 0), of ends
  // (1, 0, 0) and of a smooth point (0, 0, 1).
  void TakeBackVertex(double own, int k, double smooth_share) {
    const float vertex = SharpnessAfter(vertex_sharpness_, k);
    VertexBlend blend({0, 1, 0}, vertex);
    std::size_t sharp = 0;
    for (const float s : edge_sharpness_) {
      blend.Add(SharpnessAfter(s, k), {1, 0, 0});
      if (SharpnessAfter(s, k) > 0) ++sharp;
    }
    const Vec3 shares = blend.Point({0, 0, 1});
    const bool crease = RuleOf(vertex, sharp) == VertexRule::kCrease;
    for (std::size_t i = 0; i < size(); ++i) {
      // On a crease now, or only from the next refinement on: never on two different ones.
      const float s = SharpnessAfter(edge_sharpness_[i], k);
      if ((crease ? s : Worn(s)) > 0) edge_[i] += own * shares.x / 2;
    }
    const double n = static_cast<double>(size());
    const double smooth = own * shares.z * smooth_share;
    const double around = quads_ ? smooth / (n * n) : smooth * LoopNeighbourWeight(size()) / n;
    for (std::size_t i = 0; i < size(); ++i) {
      edge_[i] += around;
      if (quads_) centroid_[i] += around;
    }
  }

  // Quads: C_i = (V + E_i + F_i + E_(i+1)) / 4.
  void SpreadCentroids() {
    if (!quads_) return;
    for (std::size_t i = 0; i < size(); ++i) {
      const double quarter = centroid_[i] / 4;
      edge_[i] += quarter;
      edge_[After(i)] += quarter;
      face_[i] = quarter;
    }
  }

  const bool quads_;
  const double bilinear_;
  float vertex_sharpness_ = 0;
  std::vector<float> edge_sharpness_;
  std::vector<double> edge_;
  std::vector<double> face_;
  std::vector<double> centroid_;
  std::vector<double> next_edge_;
};

bool IsSharp(const SurfaceLevel& level, std::size_t v) {
  const HalfEdgeMesh& mesh = level.mesh;
  if (mesh.IsBoundary(v)) return false;
  if (level.sharpness.vertex[v] > 0) return true;
  for (Index i = mesh.fan_begin()[v]; i < mesh.fan_begin()[v + 1]; ++i) {
    if (level.sharpness.edge[mesh.edge()[mesh.fan()[i]]] > 0) return true;
  }
  return false;
}

}  // namespace

absl::StatusOr<WeightedRows> SharpRows(const Context& context, RingKind kind,
                                       const SurfaceLevel& level, double bilinear) {
  WeightedRows rows;
  if (!level.sharpness.creased()) return rows;
  const HalfEdgeMesh& mesh = level.mesh;
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (v % kDefaultGrain == 0) LIMN_RETURN_IF_ERROR(context.Check());
    if (!IsSharp(level, v)) continue;
    rows.vertex.push_back(static_cast<Index>(v));
    rows.begin.push_back(rows.begin.back() + mesh.valence(v));
  }
  rows.edge.resize(rows.begin.back());
  rows.face.resize(rows.begin.back());
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, rows.vertex.size(), 64, [&](std::size_t begin, std::size_t end) {
        RingRow row(kind, bilinear);
        for (std::size_t r = begin; r < end; ++r) {
          const Index v = rows.vertex[r];
          const std::size_t first = rows.begin[r];
          const std::size_t n = rows.begin[r + 1] - first;
          row.Start(n, level.sharpness.vertex[v]);
          for (Index i = mesh.fan_begin()[v]; i < mesh.fan_begin()[v + 1]; ++i) {
            row.AddEdge(level.sharpness.edge[mesh.edge()[mesh.fan()[i]]]);
          }
          row.Find();
          for (std::size_t i = 0; i < n; ++i) {
            rows.edge[first + i] = row.edge(i);
            rows.face[first + i] = row.face(i);
          }
        }
      }));
  return rows;
}

}  // namespace limn
