// SPDX-License-Identifier: MIT
#include "engine/constraints/fair_smooth.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// Along an edge that is shorter than this part of its neighbour in the face, this part is taken.
constexpr double kShortest = 1e-3;
// And one that is shorter than this part of the longest: powers of it stay far from overflow.
constexpr double kTiniest = 1e-20;

// One of a corner's two directions: the weights of W_beside - W and W_across - W, or these
// differences' part in the gradient, and the same for both.
template <class T>
struct Sides {
  T beside;
  T across;
};
template <class T>
struct AtCorner {
  Sides<T> leaving;
  Sides<T> entering;
};

class Smoother {
 public:
  Smoother(const Context& context, const FairFaces& faces, absl::Span<Vec3> x)
      : context_(context), faces_(faces), mesh_(faces.mesh()), walk_(mesh_), x_(x) {}

  absl::Status Run(int sweeps) {
    LIMN_RETURN_IF_ERROR(Weigh());
    LIMN_RETURN_IF_ERROR(Start());
    for (int sweep = 0; sweep < sweeps && residual_ > 0; ++sweep) LIMN_RETURN_IF_ERROR(Step());
    return absl::OkStatus();
  }

 private:
  template <class Body>
  absl::Status ForCorners(const Body& body) {
    return ParallelFor(context_, mesh_.half_edge_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t h = begin; h < end; ++h) body(static_cast<Index>(h));
    });
  }

  Index CounterClockwise(Index h) const { return RotateCcw(walk_, mesh_.twin(), h); }
  Index Clockwise(Index h) const { return RotateCw(walk_, mesh_.twin(), h); }
  double Length(Index h) const {
    return Norm(faces_.centre(mesh_.vertex()[walk_.Next(h)]) - faces_.centre(mesh_.vertex()[h]));
  }

  // Lengths in units of the longest edge, so that no power overflows.
  absl::Status Weigh() {
    double longest = 0;
    LIMN_RETURN_IF_ERROR(ParallelMax(
        context_, mesh_.half_edge_count(), 0,
        [&](std::size_t begin, std::size_t end) {
          double best = 0;
          for (std::size_t h = begin; h < end; ++h) {
            best = std::max(best, Length(static_cast<Index>(h)));
          }
          return best;
        },
        &longest));
    const double unit = longest > 0 ? 1 / longest : 0;
    weight_.resize(mesh_.half_edge_count());
    LIMN_RETURN_IF_ERROR(ForCorners([&](Index h) {
      const Index prev = walk_.Prev(h);
      const double leaving = unit * Length(h);
      const double entering = unit * Length(prev);
      // The edges that go on beyond the vertex: in the next faces, the other one at the vertex.
      const Index ccw = CounterClockwise(h);
      const Index cw = Clockwise(h);
      const double beyond = ccw == kNoIndex ? leaving : unit * Length(walk_.Prev(ccw));
      const double before = cw == kNoIndex ? entering : unit * Length(cw);
      weight_[h] = {Weights(leaving, beyond, entering), Weights(entering, before, leaving)};
    }));
    return Precondition();
  }
  // The square root of the term's weight is in both.
  static Sides<double> Weights(double along, double onward, double width) {
    const double shortest = std::max(kShortest * width, kTiniest);
    const double a = std::max(along, shortest);
    const double b = std::max(onward, shortest);
    const double beside = a / 2;
    const double across = a * b / (a + b);
    const double root = std::sqrt(width / (beside + across));
    return {root / beside, root / across};
  }

  // The mean of the operator's diagonal over each face: a multiple of the identity there, so that
  // it commutes with the projection.
  absl::Status Precondition() {
    inverse_.resize(faces_.vertex_count());
    return ParallelFor(context_, faces_.vertex_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        double diagonal = 0;
        for (const Index h : faces_.Fan(v)) {
          diagonal += Square(weight_[walk_.Prev(h)].leaving.beside) +
                      Square(weight_[walk_.Next(h)].entering.beside) +
                      Own(weight_[h].leaving, CounterClockwise(h)) +
                      Own(weight_[h].entering, Clockwise(h));
        }
        inverse_[v] = diagonal > 0 ? static_cast<double>(faces_.Fan(v).size()) / diagonal : 0;
      }
    });
  }
  static double Square(double x) { return x * x; }
  // W's square in its own difference and W_across's, which is of the same face; a ghost is -W.
  static double Own(const Sides<double>& weight, Index across) {
    if (across == kNoIndex) return Square(weight.beside + 2 * weight.across);
    return Square(weight.beside + weight.across) + Square(weight.across);
  }

  // Sets difference_ for changes of points, whose ghosts are just the opposite; for points
  // themselves with what AddCurve adds.
  absl::Status Differences(absl::Span<const Vec3> points) {
    return ForCorners([&](Index h) {
      const auto at = [&](const Sides<double>& weight, Index beside, Index across) {
        const Vec3 own = points[h];
        const Vec3 beyond = across == kNoIndex ? -own : points[across];
        const Vec3 d = weight.beside * (points[beside] - own) + weight.across * (beyond - own);
        return Sides<Vec3>{weight.beside * d, weight.across * d};
      };
      difference_[h] = {at(weight_[h].leaving, walk_.Next(h), CounterClockwise(h)),
                        at(weight_[h].entering, walk_.Prev(h), Clockwise(h))};
    });
  }
  absl::Status AddCurve() {
    const BoundaryCurve& curve = faces_.boundary();
    const auto add = [](const Sides<double>& weight, const Vec3& point, Sides<Vec3>* difference) {
      const Vec3 d = 2 * weight.across * point;
      difference->beside += weight.beside * d;
      difference->across += weight.across * d;
    };
    return ParallelFor(context_, curve.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Index h = curve.half_edge[i];
        const Index next = walk_.Next(h);
        add(weight_[h].entering, curve.start[i] - curve.origin, &difference_[h].entering);
        add(weight_[next].leaving, curve.end[i] - curve.origin, &difference_[next].leaving);
      }
    });
  }

  // The gradient's part of corner h: the transpose, applied to the differences.
  Vec3 Gather(Index h) const {
    const auto& d = difference_;
    const Index clockwise = Clockwise(h);
    const Index counter_clockwise = CounterClockwise(h);
    Vec3 sum = d[walk_.Prev(h)].leaving.beside + d[walk_.Next(h)].entering.beside;
    sum -= d[h].leaving.beside + d[h].leaving.across;
    sum -= d[h].entering.beside + d[h].entering.across;
    sum += clockwise == kNoIndex ? -d[h].entering.across : d[clockwise].leaving.across;
    sum +=
        counter_clockwise == kNoIndex ? -d[h].leaving.across : d[counter_clockwise].entering.across;
    return sum;
  }

  // residual = -projected gradient; direction = preconditioned residual.
  absl::Status Start() {
    const std::size_t n = mesh_.half_edge_count();
    difference_.resize(n);
    r_.resize(n);
    p_.resize(n);
    q_.resize(n);
    LIMN_RETURN_IF_ERROR(Differences(x_));
    LIMN_RETURN_IF_ERROR(AddCurve());
    return ParallelSum(
        context_, faces_.vertex_count(),
        [&](std::size_t v) {
          for (const Index h : faces_.Fan(v)) r_[h] = -Gather(h);
          faces_.Project(v, absl::MakeSpan(r_));
          double sum = 0;
          for (const Index h : faces_.Fan(v)) {
            p_[h] = inverse_[v] * r_[h];
            sum += Dot(r_[h], p_[h]);
          }
          return sum;
        },
        &residual_);
  }

  absl::Status Step() {
    LIMN_RETURN_IF_ERROR(Differences(p_));
    double curvature = 0;
    LIMN_RETURN_IF_ERROR(ParallelSum(
        context_, faces_.vertex_count(),
        [&](std::size_t v) {
          for (const Index h : faces_.Fan(v)) q_[h] = Gather(h);
          faces_.Project(v, absl::MakeSpan(q_));
          double sum = 0;
          for (const Index h : faces_.Fan(v)) sum += Dot(p_[h], q_[h]);
          return sum;
        },
        &curvature));
    if (!(curvature > 0)) {
      residual_ = 0;
      return absl::OkStatus();
    }
    const double step = residual_ / curvature;
    const double before = residual_;
    LIMN_RETURN_IF_ERROR(ParallelSum(
        context_, faces_.vertex_count(),
        [&](std::size_t v) {
          double sum = 0;
          for (const Index h : faces_.Fan(v)) {
            x_[h] += step * p_[h];
            r_[h] -= step * q_[h];
            sum += inverse_[v] * Dot(r_[h], r_[h]);
          }
          return sum;
        },
        &residual_));
    const double ratio = residual_ / before;
    return ParallelFor(context_, faces_.vertex_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        for (const Index h : faces_.Fan(v)) p_[h] = inverse_[v] * r_[h] + ratio * p_[h];
      }
    });
  }

  const Context& context_;
  const FairFaces& faces_;
  const HalfEdgeMesh& mesh_;
  const PolygonWalk walk_;
  absl::Span<Vec3> x_;
  Buffer<AtCorner<double>> weight_;
  Buffer<AtCorner<Vec3>> difference_;
  // One per vertex.
  Buffer<double> inverse_;
  Buffer<Vec3> r_;
  Buffer<Vec3> p_;
  Buffer<Vec3> q_;
  // r . (preconditioned r).
  double residual_ = 0;
};

}  // namespace

absl::Status SmoothCorners(const Context& context, const FairFaces& faces, int sweeps,
                           absl::Span<Vec3> corners) {
  return Smoother(context, faces, corners).Run(sweeps);
}

}  // namespace limn
