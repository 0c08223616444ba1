// SPDX-License-Identifier: MIT
#include "engine/limit/ring_deviation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/types/span.h"
#include "engine/limit/ring_cones.h"
#include "engine/limit/ring_reach.h"
#include "engine/refine/harmonics.h"

namespace limn {
namespace {

// Generations beyond the deepest that are looked at: what is left of them counts in full, so that
// it should be small.
constexpr int kBeyond = 4;

void Translate(const Vec3& by, PatchRing* ring) {
  for (auto* points : {&ring->center, &ring->right, &ring->left, &ring->diagonal}) {
    for (Vec3& p : *points) p += by;
  }
}

// The part F of a ring. Its points solve 2 x (image by refinement) = point.
PatchRing FirstHarmonicOf(const PatchRing& ring, const Harmonics& harmonics) {
  PatchRing first = ring;
  const std::size_t sides = ring.center.size();
  for (std::size_t i = 0; i < sides; ++i) {
    const UnitAngle angle = AngleOf(i, sides);
    first.center[i] =
        2.0 / static_cast<double>(sides) * (angle.cos * harmonics.t1 + angle.sin * harmonics.t2);
  }
  for (std::size_t i = 0; i <= ring.sectors; ++i) {
    const Vec3& own = first.Corner(i);
    const Vec3& clockwise = first.Corner(i + sides - 1);
    first.right[i] = 2 * own + clockwise;
    first.left[i] = own + 2 * clockwise;
  }
  for (std::size_t i = 0; i < ring.sectors; ++i) {
    first.diagonal[i] = 1.0 / 7 * (9 * first.center[i] + 3 * (first.right[i] + first.left[i + 1]));
  }
  return first;
}

// A bound of all points' E at a generation and after it, from those at it. With center <= w, the
// edges' points <= r and diagonals <= d, the next are at most w / 2, (3 w + r) / 2 and
// (9 w + 6 r + d) / 8: r stays below r + 3/2 w, and d below the larger of d and (9 w + 6 r) / 7.
double EnvelopeOf(double w, double r, double d) {
  const double edges = r + 1.5 * w;
  return std::max({w, edges, d, (9 * w + 6 * edges) / 7});
}

Deviation RemainderOf(const PatchRing& ring, const PatchRing& first, const Vec3& normal) {
  const auto most = [&](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    Deviation largest;
    for (std::size_t i = 0; i < a.size(); ++i) largest.Widen(PartsOf(a[i] - b[i], normal));
    return largest;
  };
  const Deviation center = most(ring.center, first.center);
  Deviation edges = most(ring.right, first.right);
  edges.Widen(most(ring.left, first.left));
  const Deviation diagonal = most(ring.diagonal, first.diagonal);
  return {EnvelopeOf(center.height, edges.height, diagonal.height),
          EnvelopeOf(center.slide, edges.slide, diagonal.slide)};
}

// What one refinement of a sector says; see BoundRing.
struct Step {
  // Vertices of the next tessellation from the bilinear quad of this one.
  Deviation delta;
  // The quad from its triangles.
  Deviation split;
  // The quarters of the next generation, from their bilinear quads and from their triangles.
  Deviation quarter;
  Deviation quarter_split;

  void Widen(const Step& other) {
    delta.Widen(other.delta);
    split.Widen(other.split);
    quarter.Widen(other.quarter);
    quarter_split.Widen(other.quarter_split);
  }
};

Step StepOf(const RefinedGrid& grid, const Vec3& normal) {
  const auto [low, middle, high] = VerticesOf(grid);
  Step step;
  const auto widen = [&](const Vec3& p, const Vec3& a, const Vec3& b) {
    step.delta.Widen(PartsOf(p - 0.5 * (a + b), normal));
  };
  widen(low[1], low[0], low[2]);
  widen(high[1], high[0], high[2]);
  widen(middle[0], low[0], high[0]);
  widen(middle[2], low[2], high[2]);
  widen(middle[1], 0.5 * (low[0] + low[2]), 0.5 * (high[0] + high[2]));
  step.split = 0.25 * PartsOf((low[0] - low[2]) - (high[0] - high[2]), normal);
  for (std::size_t quarter = 1; quarter < 4; ++quarter) {
    const NetDeviation deviation = DeviationOf(QuarterNet(grid, quarter / 2, quarter % 2), normal);
    step.quarter.Widen(deviation.bilinear);
    step.quarter_split.Widen(deviation.sum());
  }
  return step;
}

Step operator*(double s, const Step& a) {
  return {s * a.delta, s * a.split, s * a.quarter, s * a.quarter_split};
}

// What is left of the ring, from its bilinear quads: that of F alone, whose deviation halves at
// each step, and of E, whose points are all that far from their plane and place.
Deviation Rest(const PatchRing& ring, const RingRefiner& first, const Deviation& remainder,
               const Vec3& normal) {
  Step step;
  for (std::size_t i = 0; i < ring.sectors; ++i) step.Widen(StepOf(first.grid(i), normal));
  const double slide = std::max(step.delta.slide + step.quarter.slide, 2 * step.delta.slide);
  return {2 * remainder.height, slide + 2 * remainder.slide};
}

// The same for two sides, whose first harmonic is not halved: a bound of all points.
Deviation RestOfTwo(const PatchRing& ring) {
  double largest = 0;
  for (const auto* points : {&ring.center, &ring.right, &ring.left, &ring.diagonal}) {
    for (const Vec3& p : *points) largest = std::max(largest, Norm(p));
  }
  return {0, 2 * largest};
}

// The distance where a cone holds all that a path may get to.
double DistanceWhereHeld(const Deviation& deviation, const ProjectedCone& cone) {
  return std::min(deviation.length(), deviation.height + std::tan(cone.angle) * deviation.slide);
}

// The ring at level 2 + j: what is left, R_j, and the generations 1 .. j, of which generation g is
// in R_(g - 1) but not in R_g.
class LevelOfRing {
 public:
  LevelOfRing(int j, absl::Span<const Step> steps, const Deviation& left, const RingReach& reach)
      : j_(j), steps_(steps), left_(left), reach_(reach) {}

  // Of all that paths from generation g to R_outer's end may get to.
  Deviation WithinReach(int g, int outer) const {
    const int end = reach_.EndOfPaths(g);
    Deviation worst;
    if (end > j_) worst = Rest();
    for (int other = outer + 1; other <= std::min(end, j_); ++other) worst.Widen(Quarter(other));
    return worst;
  }

  // The bound of the distance of what is in R_1. cones: of R_0, R_1, ...
  double BoundInside(absl::Span<const ProjectedCone> cones) const {
    if (j_ == 0) return 0;
    double worst = Best(j_ + 1, cones);
    for (int g = 2; g <= j_; ++g) worst = std::max(worst, Best(g, cones));
    return worst;
  }

 private:
  Deviation Rest() const { return steps_[static_cast<std::size_t>(j_)].split + left_; }
  Deviation Quarter(int g) const {
    return std::ldexp(1, -2 * (j_ - g)) * steps_[static_cast<std::size_t>(g - 1)].quarter_split;
  }
  // Of generation g, or, beyond j, of what is left. With the best of the R around it: the larger
  // one holds its paths, the smaller one turns less. At a boundary the worst deviation on the way
  // counts.
  double Best(int g, absl::Span<const ProjectedCone> cones) const {
    const Deviation own = g > j_ ? Rest() : Quarter(g);
    const int inner = g - 1;
    double best = own.length();
    for (int outer = inner - 1; outer >= 0; --outer) {
      const ProjectedCone& cone = cones[static_cast<std::size_t>(outer)];
      if (!cone.valid() || !reach_.Holds(outer, inner)) continue;
      best = std::min(best,
                      DistanceWhereHeld(reach_.at_boundary() ? WithinReach(g, outer) : own, cone));
    }
    return best;
  }

  int j_;
  absl::Span<const Step> steps_;
  Deviation left_;
  const RingReach& reach_;
};

}  // namespace

bool StaysWithin(const Deviation& deviation, const ProjectedCone& cone, double room) {
  return cone.valid() && deviation.slide < std::cos(cone.angle) * cone.stretch * room;
}

double DistanceBound(const Deviation& deviation, const ProjectedCone& cone, double room) {
  return StaysWithin(deviation, cone, room) ? DistanceWhereHeld(deviation, cone)
                                            : deviation.length();
}

RingBounds BoundRing(PatchRing* ring, int deepest) {
  const std::size_t sides = ring->center.size();
  const Harmonics harmonics = FirstHarmonics(sides, [&](std::size_t i) { return ring->center[i]; });
  const double size = static_cast<double>(sides) * MaxAbs(harmonics.mean);
  const bool two = sides == 2;
  const Vec3 normal = two ? Vec3{0, 0, 0} : UnitCross(harmonics.t1, harmonics.t2, size);
  Translate(-harmonics.mean, ring);
  PatchRing first = FirstHarmonicOf(*ring, harmonics);
  const RingRefiner first_refiner(&first);
  const RoundFrame frame(harmonics, normal);
  RingCones cones(frame, first_refiner, *ring);
  RingReach reach(frame, *ring);

  const int steps = deepest + kBeyond + 1;
  std::vector<Step> step(static_cast<std::size_t>(steps));
  RingRefiner refiner(ring);
  double scale = 1;
  for (Step& here : step) {
    for (std::size_t i = 0; i < ring->sectors; ++i) here.Widen(StepOf(refiner.grid(i), normal));
    here = scale * here;
    cones.AddGeneration(refiner);
    reach.AddGeneration(refiner);
    refiner.Advance(2);
    scale *= 0.5;
  }
  const Deviation remainder = RemainderOf(*ring, first, normal);
  const std::vector<ProjectedCone> cone = cones.Finish(remainder);
  reach.Finish(first_refiner, remainder.slide);

  // Of what is left after j steps, from its quads: each step adds its delta, and then either a
  // quarter or what is left after one more is the worst.
  std::vector<Deviation> left(step.size() + 1);
  left.back() = scale * (two ? RestOfTwo(*ring) : Rest(*ring, first_refiner, remainder, normal));
  for (std::size_t j = step.size(); j-- > 0;) {
    left[j] = left[j + 1];
    left[j].Widen(step[j].quarter);
    left[j] = step[j].delta + left[j];
  }

  RingBounds bounds;
  bounds.cone = cone[0];
  bounds.deviation = step[0].split + left[0];
  bounds.deviation.Widen(4 * step[0].quarter_split);
  for (int j = 0; j <= deepest; ++j) {
    const LevelOfRing level(j, step, left[static_cast<std::size_t>(j)], reach);
    bounds.inside[static_cast<std::size_t>(j)] = level.BoundInside(cone);
    bounds.within_reach[static_cast<std::size_t>(j)] = level.WithinReach(1, 0);
  }
  return bounds;
}

}  // namespace limn
