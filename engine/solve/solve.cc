// SPDX-License-Identifier: MIT
#include "engine/solve/solve.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// One sweep of every method but Gauss-Seidel:
//   step = momentum * step + gain * weight * (I - L x),   x += step.
struct SweepFactors {
  double momentum = 0;
  double gain = 1;
};

// The part of a vertex's own point in its limit point: the diagonal of L.
double Diagonal(const HalfEdgeMesh& mesh, const LimitRow& row, std::size_t v) {
  const Index begin = mesh.fan_begin()[v];
  const Index end = mesh.fan_begin()[v + 1];
  double inverse_arities = 0;
  for (Index i = begin; i < end; ++i) {
    const Index f = mesh.face()[mesh.fan()[i]];
    inverse_arities += 1.0 / (mesh.face_begin()[f + 1] - mesh.face_begin()[f]);
  }
  return row.vertex + row.faces * inverse_arities / (end - begin);
}

// The unknowns and everything a sweep needs.
class Sweeper {
 public:
  Sweeper(const Context& context, const SolveProblem& problem, absl::Span<Vec3> solution)
      : context_(context),
        problem_(problem),
        x_(solution),
        centroids_(problem.mesh.face_count()),
        in_place_(!problem.stencil.uses_edges()) {}

  absl::Status Start(bool jacobi_weights, bool simultaneous) {
    const std::size_t n = problem_.points.size();
    if (jacobi_weights) weights_.resize(n);
    if (simultaneous) step_.resize(n);
    // Rows without neighbours' points see x through the centroids only, so x can change in place.
    if (simultaneous && !in_place_) next_.resize(n);
    return ParallelFor(context_, n, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        x_[v] = problem_.points[v];
        if (simultaneous) step_[v] = {0, 0, 0};
        if (jacobi_weights) {
          weights_[v] = 1 / Diagonal(problem_.mesh, problem_.stencil.row(v), v);
        }
      }
    });
  }

  // *largest: largest move of a coordinate.
  absl::Status Sweep(const SweepFactors& factors, double* largest) {
    LIMN_RETURN_IF_ERROR(FaceCentroids(context_, problem_.mesh, x_, absl::MakeSpan(centroids_)));
    const absl::Span<Vec3> out = in_place_ ? x_ : absl::MakeSpan(next_);
    LIMN_RETURN_IF_ERROR(ParallelMax(
        context_, x_.size(), 0,
        [&](std::size_t begin, std::size_t end) {
          double most = 0;
          for (std::size_t v = begin; v < end; ++v) {
            const double gain = weights_.empty() ? factors.gain : factors.gain * weights_[v];
            step_[v] = factors.momentum * step_[v] + gain * Residual(v);
            out[v] = x_[v] + step_[v];
            most = std::max(most, MaxAbs(step_[v]));
          }
          return most;
        },
        largest));
    if (in_place_) return absl::OkStatus();
    return ParallelFor(context_, x_.size(), [&](std::size_t begin, std::size_t end) {
      std::copy(next_.begin() + static_cast<std::ptrdiff_t>(begin),
                next_.begin() + static_cast<std::ptrdiff_t>(end), x_.begin() + begin);
    });
  }

  // Uses each new point at once; centroids follow by the part that changed.
  absl::Status GaussSeidelSweep(double* largest) {
    const HalfEdgeMesh& mesh = problem_.mesh;
    LIMN_RETURN_IF_ERROR(FaceCentroids(context_, mesh, x_, absl::MakeSpan(centroids_)));
    *largest = 0;
    for (std::size_t v = 0; v < x_.size(); ++v) {
      if (v % kDefaultGrain == 0) LIMN_RETURN_IF_ERROR(context_.Check());
      const Vec3 move = weights_[v] * Residual(v);
      x_[v] += move;
      *largest = std::max(*largest, MaxAbs(move));
      for (Index i = mesh.fan_begin()[v]; i < mesh.fan_begin()[v + 1]; ++i) {
        const Index f = mesh.face()[mesh.fan()[i]];
        centroids_[f] += (1.0 / (mesh.face_begin()[f + 1] - mesh.face_begin()[f])) * move;
      }
    }
    return absl::OkStatus();
  }

  // Largest coordinate of I - L x, from x alone.
  absl::Status TrueResidual(double* largest) {
    LIMN_RETURN_IF_ERROR(FaceCentroids(context_, problem_.mesh, x_, absl::MakeSpan(centroids_)));
    return ParallelMax(
        context_, x_.size(), 0,
        [&](std::size_t begin, std::size_t end) {
          double most = 0;
          for (std::size_t v = begin; v < end; ++v) most = std::max(most, MaxAbs(Residual(v)));
          return most;
        },
        largest);
  }

 private:
  Vec3 Residual(std::size_t v) const {
    return problem_.points[v] -
           LimitPoint(problem_.mesh, problem_.stencil.row(v), x_, centroids_, v);
  }

  const Context& context_;
  const SolveProblem& problem_;
  absl::Span<Vec3> x_;
  Buffer<Vec3> centroids_;
  Buffer<Vec3> step_;
  Buffer<Vec3> next_;
  // Inverse diagonal of L, for Jacobi and Gauss-Seidel.
  Buffer<double> weights_;
  bool in_place_;
};

// The factors of sweep 0, 1, 2 ... of the Chebyshev semi-iteration for a spectrum within
// [low, high].
class ChebyshevFactors {
 public:
  ChebyshevFactors(double low, double high) : theta_((high + low) / 2), delta_((high - low) / 2) {}

  SweepFactors Next() {
    // A spectrum of one point: one exact step, and no division by delta.
    if (delta_ == 0 || first_) {
      first_ = false;
      rho_ = delta_ / theta_;
      return {.momentum = 0, .gain = 1 / theta_};
    }
    const double rho = 1 / (2 * theta_ / delta_ - rho_);
    const SweepFactors factors = {.momentum = rho * rho_, .gain = 2 * rho / delta_};
    rho_ = rho;
    return factors;
  }

 private:
  double theta_;
  double delta_;
  double rho_ = 0;
  bool first_ = true;
};

}  // namespace

absl::Status ValidateSolveOptions(const SolveOptions& options) {
  if (!(options.tolerance >= 0 && options.tolerance < 1)) {
    return MakeError(absl::StrCat("the solve's tolerance is ", options.tolerance),
                     {.reason = Reason::kInvalidOption,
                      .field = "solve.tolerance",
                      .remedy = "It must be at least 0 and below 1"});
  }
  constexpr std::uint32_t kMostSweeps = 10000;
  if (options.max_sweeps > kMostSweeps) {
    return MakeError(absl::StrCat("the solve's largest number of sweeps is ", options.max_sweeps),
                     {.reason = Reason::kInvalidOption,
                      .field = "solve.max_sweeps",
                      .remedy = absl::StrCat("It must be at most ", kMostSweeps)});
  }
  return absl::OkStatus();
}

absl::StatusOr<SolveReport> Solve(const Context& context, const SolveProblem& problem,
                                  const SolveOptions& options, absl::Span<Vec3> solution) {
  LIMN_RETURN_IF_ERROR(ValidateSolveOptions(options));
  SolveReport report;
  report.method = options.method;
  const bool serial = options.method == SolveMethod::kGaussSeidel;
  Sweeper sweeper(context, problem, solution);
  LIMN_RETURN_IF_ERROR(sweeper.Start(options.method != SolveMethod::kChebyshev, !serial));
  ChebyshevFactors chebyshev(problem.stencil.spectrum_low, problem.stencil.spectrum_high);
  while (report.sweeps < options.max_sweeps && !report.converged) {
    double largest = 0;
    if (serial) {
      LIMN_RETURN_IF_ERROR(sweeper.GaussSeidelSweep(&largest));
    } else {
      const SweepFactors factors =
          options.method == SolveMethod::kChebyshev ? chebyshev.Next() : SweepFactors{};
      LIMN_RETURN_IF_ERROR(sweeper.Sweep(factors, &largest));
    }
    ++report.sweeps;
    report.last_update = largest / problem.scale;
    report.converged = report.last_update <= options.tolerance;
    context.Report({.stage = "solve",
                    .fraction = static_cast<double>(report.sweeps) / options.max_sweeps,
                    .sweep = report.sweeps,
                    .update = report.last_update});
  }
  LIMN_RETURN_IF_ERROR(sweeper.TrueResidual(&report.residual));
  report.residual /= problem.scale;
  return report;
}

}  // namespace limn
