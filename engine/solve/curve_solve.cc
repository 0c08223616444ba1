// SPDX-License-Identifier: MIT
#include "engine/solve/curve_solve.h"

#include <algorithm>
#include <cmath>

#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// Walks along a curve away from a vertex. A curve that ends at a fixed vertex goes on as its own
// point reflection there, so that the control point of the end is the end itself.
class CurveWalk {
 public:
  CurveWalk(const CurveProblem& problem, Index from, bool forward)
      : problem_(problem), origin_(problem.points[from]), at_(from), forward_(forward) {}

  // The difference of the next point to the point of the start.
  Vec3 Next() {
    at_ = forward_ ? problem_.curve.next[at_] : problem_.curve.previous[at_];
    const Vec3 d = problem_.points[at_] - origin_;
    const Vec3 value = reflected_ ? shift_ - d : shift_ + d;
    if (problem_.fixed[at_] != 0) {
      // x -> 2 value - x.
      shift_ = 2 * value - shift_;
      reflected_ = !reflected_;
      forward_ = !forward_;
    }
    return value;
  }

 private:
  const CurveProblem& problem_;
  const Vec3 origin_;
  Index at_;
  bool forward_;
  bool reflected_ = false;
  Vec3 shift_ = {0, 0, 0};
};

// Of a vertex that is not fixed.
double OwnWeight(const CurveProblem& problem, std::size_t i) {
  return problem.vertex_weights.empty() ? problem.stencil.vertex : problem.vertex_weights[i];
}

// The mean of the neighbours' points, as a difference to the vertex's own.
Vec3 TowardsNeighbours(const BoundaryCurve& curve, const Vec3* points, std::size_t i) {
  return 0.5 * ((points[curve.next[i]] - points[i]) + (points[curve.previous[i]] - points[i]));
}

// Jacobi sweeps for d = control - given, which stay small far from the origin.
absl::Status SolveBySweeps(const Context& context, const CurveProblem& problem,
                           absl::Span<Vec3> control) {
  constexpr int kSweeps = 56;
  const BoundaryCurve& curve = problem.curve;
  const std::size_t n = control.size();
  const Vec3* given = problem.points.data();
  Buffer<Vec3> d(n);
  Buffer<Vec3> next(n);
  for (int sweep = 0; sweep <= kSweeps; ++sweep) {
    LIMN_RETURN_IF_ERROR(ParallelFor(context, n, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        next[i] = {0, 0, 0};
        if (problem.fixed[i] != 0) continue;
        // own (given + d) + (1 - own) mean of the neighbours' (given + d) = given.
        const double own = OwnWeight(problem, i);
        Vec3 others = TowardsNeighbours(curve, given, i);
        if (sweep > 0) others += 0.5 * (d[curve.next[i]] + d[curve.previous[i]]);
        next[i] = -((1 - own) / own) * others;
      }
    }));
    d.swap(next);
  }
  return ParallelFor(context, n, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) control[i] = given[i] + d[i];
  });
}

}  // namespace

absl::Status CurveResidual(const Context& context, const CurveProblem& problem,
                           absl::Span<const Vec3> control, double* largest) {
  return ParallelMax(
      context, control.size(), 0,
      [&](std::size_t begin, std::size_t end) {
        double most = 0;
        for (std::size_t i = begin; i < end; ++i) {
          if (problem.fixed[i] != 0) continue;
          const Vec3 limit =
              (1 - OwnWeight(problem, i)) * TowardsNeighbours(problem.curve, control.data(), i);
          most = std::max(most, MaxAbs((problem.points[i] - control[i]) - limit));
        }
        return most;
      },
      largest);
}

absl::Status SolveCurves(const Context& context, const CurveProblem& problem,
                         absl::Span<Vec3> control) {
  if (!problem.vertex_weights.empty()) return SolveBySweeps(context, problem, control);
  const double a = problem.stencil.vertex;
  const double b = problem.stencil.neighbour;
  // The inverse of (b, a, b) is ratio^|i - j| / root.
  const double root = std::sqrt(a * a - 4 * b * b);
  const double ratio = (root - a) / (2 * b);
  const int terms = static_cast<int>(std::ceil(-56 / std::log2(-ratio)));
  return ParallelFor(context, control.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      control[i] = problem.points[i];
      if (problem.fixed[i] != 0) continue;
      CurveWalk after(problem, static_cast<Index>(i), true);
      CurveWalk before(problem, static_cast<Index>(i), false);
      double weight = 1 / root;
      Vec3 sum = {0, 0, 0};
      for (int k = 0; k < terms; ++k) {
        weight *= ratio;
        sum += weight * (after.Next() + before.Next());
      }
      control[i] += sum;
    }
  });
}

}  // namespace limn
