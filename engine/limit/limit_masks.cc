// SPDX-License-Identifier: MIT
#include "engine/limit/limit_masks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/refine/harmonics.h"
#include "engine/refine/loop_refine.h"

namespace limn {
namespace {

constexpr double kPi = std::numbers::pi;

// What the sector's end receives from the wave through E_1 and F_0, and what V receives from all of
// it, per unit of the left eigenvector.
struct Inflow {
  double end;
  double vertex;
};

Inflow InflowOf(RingKind kind, std::size_t f, const Wave& wave) {
  const double a = kPi / static_cast<double>(f);
  const double edges = 1 / std::tan(a / 2);  // sum of sin(i a)
  if (kind == RingKind::kTriangles) return {std::sin(a) / 8, 0.375 * edges};
  const double first_face = wave.left * std::sin(a / 2);
  const double faces = wave.left / std::sin(a / 2);
  return {std::sin(a) / 16 + first_face / 4, 0.375 * edges + 0.25 * faces};
}

SectorMask Scaled(std::size_t f, const Wave& wave, double ends) {
  // l r, the sums of the squared sines.
  const double scale = 2 / (static_cast<double>(f) * (1 + wave.left * wave.right));
  return {.edge = scale, .face = scale * wave.left, .ends = scale * ends};
}

// The left eigenvectors of a dart that are symmetric about the sharp edge. The ring away from E_0
// is a sector of n faces between E_0 and E_0, driven by the weight of V. With the weight of V
// `own`, those of the E_i, 0 < i < n, obey
//   centre p_i = neighbour (p_(i-1) + p_(i+1)) + own * source,   p_0 = p_n = 0,
// and those of the F_i are q_i = (own * from_vertex + (p_i + p_(i+1)) / 16) / (lambda - 1/4).
class DartSystem {
 public:
  DartSystem(RingKind kind, std::size_t n, double eigenvalue)
      : kind_(kind), n_(n), lambda_(eigenvalue) {
    const double m = static_cast<double>(n);
    if (kind == RingKind::kTriangles) {
      pull_ = LoopNeighbourWeight(n);
      edge_ = source_ = pull_ / m;
      centre_ = lambda_ - 0.375;
      neighbour_ = 0.125;
      return;
    }
    pull_ = 7 / (4 * m);
    edge_ = 3 / (2 * m * m);
    face_ = 1 / (4 * m * m);
    shift_ = lambda_ - 0.25;
    source_ = edge_ + face_ / (2 * shift_);
    centre_ = lambda_ - 0.375 - 1 / (32 * shift_);
    neighbour_ = 0.0625 + 1 / (64 * shift_);
  }

  // Eigenvalue 1, with own = 1: p is a constant less two exponentials from the ends.
  DartMask PointMask() {
    const double half = centre_ / (2 * neighbour_);
    const double ratio = half - std::sqrt(half * half - 1);
    const double n = static_cast<double>(n_);
    const double level = source_ / (centre_ - 2 * neighbour_);
    const double ends = level / (1 + std::pow(ratio, n));
    const auto edge_weight = [&](std::size_t i) {
      const double from_start = static_cast<double>(i);
      return level - ends * (std::pow(ratio, from_start) + std::pow(ratio, n - from_start));
    };
    const double both_ends = 2 * (ratio - std::pow(ratio, n)) / (1 - ratio);
    SetSums(1, edge_weight(1), level * (n - 1) - ends * both_ends);
    return Mask(edge_weight, 1 + end_ + edges_ + faces_);
  }

  // The wave of this angle, whose eigenvalue must be that of the constructor, with
  // own = cos(n angle / 2), which is finite everywhere.
  void SetWave(double angle) {
    angle_ = angle;
    const double n = static_cast<double>(n_);
    SetSums(std::cos(n / 2 * angle), 0, 0);
    const double edges =
        WaveLevel() * ((n - 1) * own_ - std::sin((n - 1) / 2 * angle) / std::sin(angle / 2));
    SetSums(own_, WaveEdge(1), edges);
  }

  // What is left of the equation of E_0; 0 for eigenvectors.
  double Defect() const {
    const double received = kind_ == RingKind::kTriangles
                                ? own_ * edge_ + first_edge_ / 4
                                : own_ * edge_ + first_edge_ / 8 + first_face_ / 2;
    return (lambda_ - 0.5) * end_ - received;
  }

  DartMask WaveMask(double divisor) const {
    return Mask([this](std::size_t i) { return WaveEdge(i); }, divisor);
  }

 private:
  double WaveLevel() const { return source_ / (centre_ - 2 * neighbour_); }
  double WaveEdge(std::size_t i) const {
    const double from_middle = static_cast<double>(i) - static_cast<double>(n_) / 2;
    return WaveLevel() * (own_ - std::cos(from_middle * angle_));
  }

  // From the weights of V, of E_1 and of all E_i but E_0: those of the F_i, and by the equation of
  // V that of E_0.
  void SetSums(double own, double first_edge, double edges) {
    own_ = own;
    first_edge_ = first_edge;
    edges_ = edges;
    if (kind_ == RingKind::kQuads) {
      first_face_ = FaceWeight(0, first_edge);
      faces_ = (static_cast<double>(n_) * own * face_ + edges / 8) / shift_;
    }
    end_ = 2 * (own * (lambda_ - 1 + pull_) - 0.375 * edges - 0.25 * faces_);
  }
  double FaceWeight(double before, double after) const {
    return (own_ * face_ + (before + after) / 16) / shift_;
  }

  template <class EdgeWeight>
  DartMask Mask(const EdgeWeight& edge_weight, double divisor) const {
    DartMask mask;
    mask.edge.resize(n_);
    for (std::size_t i = 1; i < n_; ++i) mask.edge[i] = edge_weight(i) / divisor;
    if (kind_ == RingKind::kQuads) {
      mask.face.resize(n_);
      for (std::size_t i = 0; i < n_; ++i) {
        const double before = i == 0 ? 0 : edge_weight(i);
        const double after = i + 1 == n_ ? 0 : edge_weight(i + 1);
        mask.face[i] = FaceWeight(before, after) / divisor;
      }
    }
    mask.edge[0] = end_ / divisor;
    return mask;
  }

  const RingKind kind_;
  const std::size_t n_;
  const double lambda_;
  // Of the smooth vertex rule: 1 - pull is its weight of V, edge and face those of E_i and F_i.
  double pull_ = 0;
  double edge_ = 0;
  double face_ = 0;
  double shift_ = 1;
  double source_ = 0;
  double centre_ = 0;
  double neighbour_ = 0;
  double angle_ = 0;
  // The weights of V, of E_0, of E_1, of all E_i but E_0, of F_0, of all F_i.
  double own_ = 0;
  double end_ = 0;
  double first_edge_ = 0;
  double edges_ = 0;
  double first_face_ = 0;
  double faces_ = 0;
};

double DartDefect(RingKind kind, std::size_t n, double angle) {
  DartSystem system(kind, n, WaveOf(kind, angle).eigenvalue);
  system.SetWave(angle);
  return system.Defect();
}

// The angle of the symmetric wave that shrinks most slowly. It lies between the smooth ring's
// 2 pi / n and the angle of eigenvalue 1/2, which are the same at regular vertices.
double DartAngle(RingKind kind, std::size_t n) {
  const double smooth = 2 * kPi / static_cast<double>(n);
  const double half = kind == RingKind::kQuads ? kPi / 2 : kPi / 3;
  if (n == (kind == RingKind::kQuads ? 4 : 6)) return smooth;
  // Away from the pole of two quads at pi; at most to the next symmetric wave of the sector.
  double low = std::min(smooth, half);
  double high = std::min({std::max(smooth, half), 1.5 * smooth, 3.0});
  low = std::max(low, smooth / 2);
  const bool sign = DartDefect(kind, n, low) > 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    if (middle <= low || middle >= high) break;
    ((DartDefect(kind, n, middle) > 0) == sign ? low : high) = middle;
  }
  return (low + high) / 2;
}

PointMask ComputePointMask(RingKind kind, std::size_t n) {
  const double m = static_cast<double>(n);
  if (kind == RingKind::kQuads) return {.edge = 4 / (m * (m + 5)), .face = 1 / (m * (m + 5))};
  return {.edge = 1 / (m + 0.375 * m / LoopNeighbourWeight(n))};
}

PointMask ComputeTangentMask(RingKind kind, std::size_t n) {
  if (n == 2) return {.edge = 0.5, .face = kind == RingKind::kQuads ? 0.5 : 0};
  const Wave wave = WaveOf(kind, 2 * kPi / static_cast<double>(n));
  const double scale = 2 / (static_cast<double>(n) * (1 + wave.left * wave.right));
  return {.edge = scale, .face = scale * wave.left};
}

// The masks of small valences, 2 and more: computing one takes longer than using it.
using MaskFunction = PointMask (*)(RingKind kind, std::size_t n);
template <MaskFunction kCompute>
PointMask Kept(RingKind kind, std::size_t n) {
  constexpr std::size_t kSmall = 32;
  struct Table {
    Table() {
      for (std::size_t m = 2; m < kSmall; ++m) {
        quads[m] = kCompute(RingKind::kQuads, m);
        triangles[m] = kCompute(RingKind::kTriangles, m);
      }
    }
    std::array<PointMask, kSmall> quads;
    std::array<PointMask, kSmall> triangles;
  };
  static const Table kTable;
  if (n < 2 || n >= kSmall) return kCompute(kind, n);
  return kind == RingKind::kQuads ? kTable.quads[n] : kTable.triangles[n];
}

}  // namespace

Wave WaveOf(RingKind kind, double angle) {
  if (kind == RingKind::kTriangles) return {.eigenvalue = 0.375 + 0.25 * std::cos(angle)};
  const double c = std::cos(angle / 2);
  const double sum = c + std::sqrt(c * c + 4);
  return {.eigenvalue = 0.25 + c * sum / 8, .left = 1 / sum, .right = 4 / sum};
}

PointMask SmoothPointMask(RingKind kind, std::size_t n) { return Kept<ComputePointMask>(kind, n); }

PointMask SmoothTangentMask(RingKind kind, std::size_t n) {
  return Kept<ComputeTangentMask>(kind, n);
}

SectorMask CreaseMask(RingKind kind, std::size_t f) {
  const Wave wave = WaveOf(kind, kPi / static_cast<double>(f));
  const Inflow inflow = InflowOf(kind, f, wave);
  // The equations of the weights of V (own) and of E_0 and E_f (ends):
  //   (lambda - 3/4) own - ends = vertex,   (lambda - 1/2) ends - own / 8 = end.
  const double determinant = (wave.eigenvalue - 1) * (wave.eigenvalue - 0.25);
  const double ends = (inflow.end * (wave.eigenvalue - 0.75) + inflow.vertex / 8) / determinant;
  return Scaled(f, wave, ends);
}

SectorMask CornerMask(RingKind kind, std::size_t f) {
  const Wave wave = WaveOf(kind, kPi / static_cast<double>(f));
  const bool wide = f > (kind == RingKind::kQuads ? 2U : 3U);
  // V gives nothing to E_0 here: (lambda - 1/2) ends = end.
  return Scaled(f, wave, wide ? InflowOf(kind, f, wave).end / (wave.eigenvalue - 0.5) : 0);
}

DartMask DartPointMask(RingKind kind, std::size_t n) { return DartSystem(kind, n, 1).PointMask(); }

DartMask DartTangentMask(RingKind kind, std::size_t n) {
  const double angle = DartAngle(kind, n);
  DartSystem system(kind, n, WaveOf(kind, angle).eigenvalue);
  system.SetWave(angle);
  const DartMask mask = system.WaveMask(1);
  // Its value on the smooth wave E_i = cos(i a), F_i = right cos((i + 1/2) a).
  const Wave smooth = WaveOf(kind, 2 * kPi / static_cast<double>(n));
  double value = 0;
  for (std::size_t i = 0; i < n; ++i) value += mask.edge[i] * AngleOf(i, n).cos;
  for (std::size_t i = 0; i < mask.face.size(); ++i) {
    value += mask.face[i] * smooth.right * AngleOf(2 * i + 1, 2 * n).cos;
  }
  return system.WaveMask(value);
}

}  // namespace limn
