// SPDX-License-Identifier: MIT
#include "engine/solve/conjugate_gradient.h"

#include <algorithm>
#include <cmath>

#include "engine/base/buffer.h"
#include "engine/solve/lanczos.h"

namespace limn {
namespace {

// A start that improves the true residual by less than this is the last one.
constexpr double kWorthwhile = 0.5;
// Recursive residuals that have grown by this do not come back.
constexpr double kGrown = 1e6;

// Starts a method from x until the true residual is small enough, starting again does not help
// (what is left is rounding, or the method cannot do better), or the steps are spent. run(progress,
// start, residual) takes the residual of x down by its recursion.
template <class Run>
absl::StatusOr<KrylovResult> WithTrueResidual(LinearSystem* system, const KrylovOptions& options,
                                              absl::Span<Vec3> x, const Run& run) {
  KrylovProgress progress(system->context(), options.tolerance, options.max_steps);
  KrylovResult result;
  Buffer<Vec3> residual(system->size());
  LIMN_RETURN_IF_ERROR(system->Residual(x, absl::MakeSpan(residual), &result.residual));
  const double first = result.residual;
  while (!progress.MetBy(result.residual) && !progress.ForbidsStep()) {
    const double before = result.residual;
    LIMN_RETURN_IF_ERROR(run(&progress, absl::MakeSpan(residual), &result));
    LIMN_RETURN_IF_ERROR(system->Residual(x, absl::MakeSpan(residual), &result.residual));
    if (result.broke_down || !(result.residual <= kWorthwhile * before)) break;
  }
  // Never worse than the start.
  if (!(result.residual <= first)) {
    result.broke_down = true;
    LIMN_RETURN_IF_ERROR(system->Reset(x));
    result.residual = first;
  }
  result.converged = !result.broke_down && progress.MetBy(result.residual);
  result.steps = progress.done();
  return result;
}

}  // namespace

absl::StatusOr<KrylovResult> ConjugateGradient(LinearSystem* system,
                                               absl::Span<const double> weights,
                                               const KrylovOptions& options, absl::Span<Vec3> x) {
  Buffer<Vec3> direction(system->size());
  Buffer<Vec3> image(system->size());
  LanczosMatrix lanczos;
  double least = 1;
  const auto run = [&](KrylovProgress* progress, absl::Span<Vec3> r,
                       KrylovResult* result) -> absl::Status {
    const auto norm = [&](std::size_t i) { return weights[i] * Dot(r[i], r[i]); };
    double rho = 0;
    double largest = 0;
    lanczos.Clear();
    LIMN_RETURN_IF_ERROR(system->Sum(norm, &rho));
    LIMN_RETURN_IF_ERROR(system->ForEach([&](std::size_t i) { direction[i] = r[i]; }));
    while (rho > 0 && !progress->ForbidsStep()) {
      double curvature = 0;
      LIMN_RETURN_IF_ERROR(system->Product(direction, absl::MakeSpan(image)));
      LIMN_RETURN_IF_ERROR(system->Sum(
          [&](std::size_t i) { return weights[i] * Dot(direction[i], image[i]); }, &curvature));
      if (!(curvature > 0)) {
        result->broke_down = true;
        return absl::OkStatus();
      }
      const double alpha = rho / curvature;
      LIMN_RETURN_IF_ERROR(ParallelMax(
          system->context(), system->size(), 0,
          [&](std::size_t begin, std::size_t end) {
            double most = 0;
            for (std::size_t i = begin; i < end; ++i) {
              x[i] += alpha * direction[i];
              r[i] -= alpha * image[i];
              most = std::max(most, system->length().Square(r[i]));
            }
            return most;
          },
          &largest));
      largest = std::sqrt(largest);
      double next = 0;
      LIMN_RETURN_IF_ERROR(system->Sum(norm, &next));
      const double beta = next / rho;
      lanczos.AddStep(alpha, beta);
      progress->Count(largest);
      if (progress->MetBy(largest)) break;
      LIMN_RETURN_IF_ERROR(
          system->ForEach([&](std::size_t i) { direction[i] = r[i] + beta * direction[i]; }));
      rho = next;
    }
    least = std::min(least, lanczos.Least());
    return absl::OkStatus();
  };
  LIMN_ASSIGN_OR_RETURN(KrylovResult result, WithTrueResidual(system, options, x, run));
  result.least_eigenvalue = result.broke_down ? 0 : least;
  return result;
}

absl::StatusOr<KrylovResult> BiconjugateGradientStabilized(LinearSystem* system,
                                                           const KrylovOptions& options,
                                                           absl::Span<Vec3> x) {
  const std::size_t n = system->size();
  Buffer<Vec3> shadow(n);
  Buffer<Vec3> direction(n);
  Buffer<Vec3> image(n);
  Buffer<Vec3> half(n);
  const auto run = [&](KrylovProgress* progress, absl::Span<Vec3> r,
                       KrylovResult* result) -> absl::Status {
    const auto with_shadow = [&](const Buffer<Vec3>& a, double* sum) {
      return system->Sum([&](std::size_t i) { return Dot(shadow[i], a[i]); }, sum);
    };
    double rho = 0;
    const double first = result->residual;
    LIMN_RETURN_IF_ERROR(system->ForEach([&](std::size_t i) { shadow[i] = direction[i] = r[i]; }));
    LIMN_RETURN_IF_ERROR(system->Sum([&](std::size_t i) { return Dot(r[i], r[i]); }, &rho));
    while (rho != 0 && !progress->ForbidsStep()) {
      double against = 0;
      LIMN_RETURN_IF_ERROR(system->Product(direction, absl::MakeSpan(image)));
      LIMN_RETURN_IF_ERROR(with_shadow(image, &against));
      const double alpha = rho / against;
      if (against == 0 || !std::isfinite(alpha)) {
        result->broke_down = true;
        return absl::OkStatus();
      }
      LIMN_RETURN_IF_ERROR(system->ForEach([&](std::size_t i) { r[i] -= alpha * image[i]; }));
      LIMN_RETURN_IF_ERROR(system->Product(r, absl::MakeSpan(half)));
      double across = 0;
      double square = 0;
      LIMN_RETURN_IF_ERROR(system->Sum([&](std::size_t i) { return Dot(half[i], r[i]); }, &across));
      LIMN_RETURN_IF_ERROR(
          system->Sum([&](std::size_t i) { return Dot(half[i], half[i]); }, &square));
      const double omega = square > 0 ? across / square : 0;
      double largest = 0;
      LIMN_RETURN_IF_ERROR(ParallelMax(
          system->context(), n, 0,
          [&](std::size_t begin, std::size_t end) {
            double most = 0;
            for (std::size_t i = begin; i < end; ++i) {
              x[i] += alpha * direction[i] + omega * r[i];
              r[i] -= omega * half[i];
              most = std::max(most, system->length().Square(r[i]));
            }
            return most;
          },
          &largest));
      largest = std::sqrt(largest);
      progress->Count(largest);
      if (progress->MetBy(largest)) break;
      if (!(largest <= kGrown * first)) {
        result->broke_down = true;
        return absl::OkStatus();
      }
      double next = 0;
      LIMN_RETURN_IF_ERROR(system->Sum([&](std::size_t i) { return Dot(shadow[i], r[i]); }, &next));
      const double beta = next / rho * (alpha / omega);
      // Out of step with its shadow: start again from here.
      if (!std::isfinite(beta)) break;
      LIMN_RETURN_IF_ERROR(system->ForEach(
          [&](std::size_t i) { direction[i] = r[i] + beta * (direction[i] - omega * image[i]); }));
      rho = next;
    }
    return absl::OkStatus();
  };
  return WithTrueResidual(system, options, x, run);
}

}  // namespace limn
