// SPDX-License-Identifier: MIT
#include "engine/solve/solve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/solve/conjugate_gradient.h"
#include "engine/solve/gauss_seidel.h"
#include "engine/solve/linear_system.h"
#include "engine/stencil/limit_operator.h"

namespace limn {
namespace {

// One sweep of every method but Gauss-Seidel:
//   step = momentum * step + gain * weight * (I - L x),   x += step.
struct SweepFactors {
  double momentum = 0;
  double gain = 1;
};

// The unknowns of the simultaneous methods and everything a sweep needs, in the operator's slots.
class Sweeper {
 public:
  Sweeper(const Context& context, const LimitOperator& limit, double scale)
      : context_(context),
        limit_(limit),
        scale_(scale),
        points_(limit.vertex_count()),
        x_(limit.vertex_count()),
        values_(limit.face_value_count()) {}

  absl::Status Start(absl::Span<const Vec3> points) {
    LIMN_RETURN_IF_ERROR(limit_.ToSlots(context_, points, absl::MakeSpan(points_)));
    return ParallelFor(context_, x_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) x_[slot] = points_[slot];
    });
  }

  // Before the first sweep.
  absl::Status StartSweeps() {
    step_.resize(x_.size());
    // Rows without neighbours' points see x through the face values only, so x can change in place.
    if (limit_.uses_edges()) next_.resize(x_.size());
    return ParallelFor(context_, x_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) step_[slot] = {0, 0, 0};
    });
  }

  absl::Status UseJacobiWeights() {
    weights_.resize(x_.size());
    LIMN_RETURN_IF_ERROR(limit_.Diagonal(context_, absl::MakeSpan(weights_)));
    return ParallelFor(context_, x_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) weights_[slot] = 1 / weights_[slot];
    });
  }

  // *largest: what the sweep is judged by, over the scale: the longest move, or the longest
  // residual before it.
  absl::Status Sweep(const SweepFactors& factors, bool by_residual, double* largest) {
    LIMN_RETURN_IF_ERROR(limit_.FaceValues(context_, x_, absl::MakeSpan(values_)));
    Vec3* const out = next_.empty() ? x_.data() : next_.data();
    const Vec3* const x = x_.data();
    const Vec3* const points = points_.data();
    Vec3* const steps = step_.data();
    const RelativeLength length(scale_);
    const auto update = [=](Index slot, const Vec3& residual, double gain) {
      const Vec3 step = factors.momentum * steps[slot] + gain * residual;
      steps[slot] = step;
      out[slot] = x[slot] + step;
      return step;
    };
    if (by_residual) {
      LIMN_RETURN_IF_ERROR(limit_.VisitLimits(
          context_, x, values_.data(),
          [=](Index slot, const Vec3& limit) {
            const Vec3 residual = points[slot] - limit;
            update(slot, residual, factors.gain);
            return length.Square(residual);
          },
          largest));
    } else {
      const double* const weights = weights_.empty() ? nullptr : weights_.data();
      LIMN_RETURN_IF_ERROR(limit_.VisitLimits(
          context_, x, values_.data(),
          [=](Index slot, const Vec3& limit) {
            const double gain = weights == nullptr ? factors.gain : weights[slot];
            return length.Square(update(slot, points[slot] - limit, gain));
          },
          largest));
    }
    *largest = std::sqrt(*largest);
    if (!next_.empty()) x_.swap(next_);
    return absl::OkStatus();
  }

  // The longest of I - L x over the scale, from x alone.
  absl::Status TrueResidual(double* largest) {
    const RelativeLength length(scale_);
    LIMN_RETURN_IF_ERROR(limit_.FaceValues(context_, x_, absl::MakeSpan(values_)));
    LIMN_RETURN_IF_ERROR(limit_.VisitLimits(
        context_, x_.data(), values_.data(),
        [&](Index slot, const Vec3& limit) {
          const Vec3 residual = points_[slot] - limit;
          return IsFinite(residual) ? length.Square(residual)
                                    : std::numeric_limits<double>::infinity();
        },
        largest));
    *largest = std::sqrt(*largest);
    return absl::OkStatus();
  }

  // Shares the room for face values.
  LinearSystem System() { return {context_, limit_, points_, scale_, absl::MakeSpan(values_)}; }
  absl::Span<Vec3> x() { return absl::MakeSpan(x_); }

  absl::Status SetX(absl::Span<const Vec3> x) {
    return limit_.ToSlots(context_, x, absl::MakeSpan(x_));
  }
  absl::Status GetX(absl::Span<Vec3> x) const { return limit_.FromSlots(context_, x_, x); }

 private:
  const Context& context_;
  const LimitOperator& limit_;
  const double scale_;
  Buffer<Vec3> points_;
  Buffer<Vec3> x_;
  Buffer<Vec3> values_;
  Buffer<Vec3> step_;
  Buffer<Vec3> next_;
  // Inverse diagonal of L, for Jacobi.
  Buffer<double> weights_;
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

// Moves this far, in diagonals of the bounding box, seldom come back, and what does has lost as
// many digits.
constexpr double kDiverged = 1e3;

// What a Chebyshev sweep for the spectrum [1/2, 1] divides residuals by, about.
constexpr double kReduction = 6;
// Solutions are no further away than residuals over the least eigenvalue, of which more than this
// is not counted: rounding would stop all progress.
constexpr double kLeastCounted = 0.25;

// Sweeps until what they are judged by is small enough [ZC section 3.4, step 2].
template <class SweepFunction>
absl::Status Iterate(const Context& context, const SolveOptions& options,
                     const SweepFunction& sweep, SolveReport* report) {
  while (report->sweeps < options.max_sweeps && !report->converged) {
    double largest = 0;
    LIMN_RETURN_IF_ERROR(sweep(&largest));
    ++report->sweeps;
    report->last_update = largest;
    report->converged = report->last_update <= options.tolerance;
    if (!(report->last_update <= kDiverged)) {
      return MakeError(absl::StrCat("the iteration diverges: sweep ", report->sweeps,
                                    " moves a vertex by ", report->last_update, " diagonals"),
                       {.reason = Reason::kInvalidOption,
                        .field = "solve.method",
                        .remedy = "Use the default, which suits the mesh"});
    }
    context.Report({.stage = "solve",
                    .fraction = static_cast<double>(report->sweeps) / options.max_sweeps,
                    .sweep = report->sweeps,
                    .update = report->last_update});
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateSolveOptions(const SolveOptions& options) {
  if (!(options.tolerance >= 0 && options.tolerance < 1)) {
    return MakeError(absl::StrCat("the solve's tolerance is ", options.tolerance),
                     {.reason = Reason::kInvalidOption,
                      .field = "solve.tolerance",
                      .remedy = "It must be at least 0 and below 1"});
  }
  if (options.max_sweeps > kMaxSweeps) {
    return MakeError(absl::StrCat("the solve's largest number of sweeps is ", options.max_sweeps),
                     {.reason = Reason::kInvalidOption,
                      .field = "solve.max_sweeps",
                      .remedy = absl::StrCat("It must be at most ", kMaxSweeps)});
  }
  return absl::OkStatus();
}

namespace {

// Chebyshev's sweeps to a tolerance grow like the root of the condition number; below this bound
// conjugate gradients, which see the spectrum as it is, are the better choice.
constexpr double kLeastBound = kLeastRegularEigenvalue;

SolveMethod Choose(SolveMethod asked, const LimitOperator& limit) {
  if (asked != SolveMethod::kAutomatic) return asked;
  return limit.spectrum_low() >= kLeastBound ? SolveMethod::kChebyshev
                                             : SolveMethod::kConjugateGradient;
}

absl::Status CheckMethod(SolveMethod method, const LimitOperator& limit) {
  if (method == SolveMethod::kChebyshev && !(limit.spectrum_low() > 0)) {
    return MakeError("no bound of the spectrum is proved for this mesh, which Chebyshev needs",
                     {.reason = Reason::kInvalidOption,
                      .field = "solve.method",
                      .remedy = "Use conjugate gradients or the default"});
  }
  if (method == SolveMethod::kGaussSeidel && !limit.symmetric()) {
    return MakeError("Gauss-Seidel sweeps are for meshes on which nothing is sharp",
                     {.reason = Reason::kInvalidOption,
                      .field = "solve.method",
                      .remedy = "Use conjugate gradients or the default"});
  }
  return absl::OkStatus();
}

absl::Status SolveSerially(const Context& context, const SolveProblem& problem,
                           const SolveOptions& options, absl::Span<Vec3> x, SolveReport* report) {
  std::copy(problem.points.begin(), problem.points.end(), x.begin());
  GaussSeidel serial(problem, x);
  return Iterate(
      context, options, [&](double* largest) { return serial.Sweep(context, largest); }, report);
}

absl::Status SolveBySweeps(const Context& context, const LimitOperator& limit,
                           const SolveOptions& options, Sweeper* sweeper, SolveReport* report) {
  LIMN_RETURN_IF_ERROR(sweeper->StartSweeps());
  const bool chebyshev = report->method == SolveMethod::kChebyshev;
  if (report->method == SolveMethod::kJacobi) LIMN_RETURN_IF_ERROR(sweeper->UseJacobiWeights());
  if (!chebyshev) {
    return Iterate(
        context, options, [&](double* largest) { return sweeper->Sweep({}, false, largest); },
        report);
  }
  // Moves can vanish by accident, at a zero of the polynomial, so that residuals decide. A sweep
  // sees those before it; near the end the ones that it leaves are looked at.
  ChebyshevFactors factors(limit.spectrum_low(), limit.spectrum_high());
  const double distance = 1 / std::max(limit.spectrum_low(), kLeastCounted);
  return Iterate(
      context, options,
      [&](double* largest) -> absl::Status {
        LIMN_RETURN_IF_ERROR(sweeper->Sweep(factors.Next(), true, largest));
        *largest *= distance;
        if (*largest > kReduction * options.tolerance) return absl::OkStatus();
        LIMN_RETURN_IF_ERROR(sweeper->TrueResidual(largest));
        *largest *= distance;
        return absl::OkStatus();
      },
      report);
}

absl::Status SolveByConjugateGradients(const Context& context, const LimitOperator& limit,
                                       const SolveOptions& options, Sweeper* sweeper,
                                       SolveReport* report) {
  const KrylovOptions krylov = {.tolerance = options.tolerance, .max_steps = options.max_sweeps};
  LinearSystem system = sweeper->System();
  KrylovResult result;
  if (limit.symmetric()) {
    Buffer<double> weights(limit.vertex_count());
    LIMN_RETURN_IF_ERROR(limit.SymmetricWeights(context, absl::MakeSpan(weights)));
    LIMN_ASSIGN_OR_RETURN(result, ConjugateGradient(&system, weights, krylov, sweeper->x()));
  } else {
    LIMN_ASSIGN_OR_RETURN(result, BiconjugateGradientStabilized(&system, krylov, sweeper->x()));
  }
  report->sweeps = result.steps;
  report->converged = result.converged;
  report->last_update = result.residual;
  report->least_eigenvalue = result.least_eigenvalue;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SolveReport> Solve(const Context& context, const SolveProblem& problem,
                                  const SolveOptions& options, absl::Span<Vec3> solution) {
  LIMN_RETURN_IF_ERROR(ValidateSolveOptions(options));
  LIMN_ASSIGN_OR_RETURN(const LimitOperator limit,
                        LimitOperator::Make(context, problem.mesh, problem.stencil));
  SolveReport report;
  report.method = Choose(options.method, limit);
  report.least_eigenvalue = std::max(0.0, limit.spectrum_low());
  LIMN_RETURN_IF_ERROR(CheckMethod(report.method, limit));
  Sweeper sweeper(context, limit, problem.scale);
  LIMN_RETURN_IF_ERROR(sweeper.Start(problem.points));
  if (report.method == SolveMethod::kGaussSeidel) {
    LIMN_RETURN_IF_ERROR(SolveSerially(context, problem, options, solution, &report));
    LIMN_RETURN_IF_ERROR(sweeper.SetX(solution));
  } else {
    LIMN_RETURN_IF_ERROR(report.method == SolveMethod::kConjugateGradient
                             ? SolveByConjugateGradients(context, limit, options, &sweeper, &report)
                             : SolveBySweeps(context, limit, options, &sweeper, &report));
    LIMN_RETURN_IF_ERROR(sweeper.GetX(solution));
  }
  LIMN_RETURN_IF_ERROR(sweeper.TrueResidual(&report.residual));
  return report;
}

}  // namespace limn
