// SPDX-License-Identifier: MIT
#include "engine/solve/least_eigenvalue.h"

#include <cmath>
#include <cstddef>

#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/base/vec3.h"
#include "engine/solve/lanczos.h"
#include "engine/solve/linear_system.h"

namespace limn {
namespace {

// Chance of missing an eigenvalue.
constexpr double kMissed = 1e-3;
// A residual that has shrunk by this, squared, is spent: all that the start holds has been seen.
constexpr double kSpent = 1e-24;

// A number of zero mean from the bits of a counter (Steele, Lea and Flood, "Fast splittable
// pseudorandom number generators", 2014), near enough to normal: the sum of four uniform ones.
double RandomNumber(std::uint64_t counter) {
  std::uint64_t z = (counter + 1) * 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  z ^= z >> 31;
  const std::uint64_t sum = (z & 0xffff) + ((z >> 16) & 0xffff) + ((z >> 32) & 0xffff) + (z >> 48);
  return static_cast<double>(sum) / 65536 - 2;
}

// How far, as a part of the spectrum's width, the least Ritz value may still be above the least
// eigenvalue after k steps.
double LargestError(std::size_t vertices, std::uint32_t k) {
  const double root =
      std::log(1.648 * std::sqrt(static_cast<double>(vertices)) / kMissed) / (2.0 * k - 1);
  return root * root;
}

// Steps of conjugate gradients for L x = start, without x.
class Probe {
 public:
  Probe(const Context& context, const LimitOperator& limit)
      : context_(context),
        limit_(limit),
        weights_(limit.vertex_count()),
        residual_(limit.vertex_count()),
        direction_(limit.vertex_count()),
        image_(limit.vertex_count()),
        values_(limit.face_value_count()),
        system_(context, limit, residual_, 1, absl::MakeSpan(values_)) {}

  absl::StatusOr<bool> Run(double bound) {
    LIMN_RETURN_IF_ERROR(Start());
    const double first = rho_;
    for (std::uint32_t k = 1; k <= kMaxProbeSteps && rho_ > kSpent * first; ++k) {
      bool positive = false;
      LIMN_RETURN_IF_ERROR(Step(&positive));
      if (!positive || lanczos_.CountBelow(bound) > 0) return true;
      const double error = LargestError(weights_.size(), k);
      if (error < 1 && lanczos_.CountBelow(bound + error * (1 - bound)) == 0) return false;
    }
    return false;
  }

 private:
  // Independent and of one variance where L is symmetric, which it is once scaled by the roots of
  // the weights.
  absl::Status Start() {
    LIMN_RETURN_IF_ERROR(limit_.SymmetricWeights(context_, absl::MakeSpan(weights_)));
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, image_.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) {
            const std::uint64_t at = 3 * std::uint64_t{v};
            image_[v] = {RandomNumber(at), RandomNumber(at + 1), RandomNumber(at + 2)};
          }
        }));
    LIMN_RETURN_IF_ERROR(limit_.ToSlots(context_, image_, absl::MakeSpan(residual_)));
    LIMN_RETURN_IF_ERROR(system_.ForEach([&](std::size_t i) {
      residual_[i] *= 1 / std::sqrt(weights_[i]);
      direction_[i] = residual_[i];
    }));
    return system_.Sum([&](std::size_t i) { return weights_[i] * Dot(residual_[i], residual_[i]); },
                       &rho_);
  }

  absl::Status Step(bool* positive) {
    double curvature = 0;
    LIMN_RETURN_IF_ERROR(system_.Product(direction_, absl::MakeSpan(image_)));
    LIMN_RETURN_IF_ERROR(system_.Sum(
        [&](std::size_t i) { return weights_[i] * Dot(direction_[i], image_[i]); }, &curvature));
    *positive = curvature > 0;
    if (!*positive) return absl::OkStatus();
    const double alpha = rho_ / curvature;
    double next = 0;
    LIMN_RETURN_IF_ERROR(system_.Sum(
        [&](std::size_t i) {
          residual_[i] -= alpha * image_[i];
          return weights_[i] * Dot(residual_[i], residual_[i]);
        },
        &next));
    const double beta = next / rho_;
    lanczos_.AddStep(alpha, beta);
    rho_ = next;
    return system_.ForEach(
        [&](std::size_t i) { direction_[i] = residual_[i] + beta * direction_[i]; });
  }

  const Context& context_;
  const LimitOperator& limit_;
  Buffer<double> weights_;
  Buffer<Vec3> residual_;
  Buffer<Vec3> direction_;
  Buffer<Vec3> image_;
  Buffer<Vec3> values_;
  LinearSystem system_;
  LanczosMatrix lanczos_;
  double rho_ = 0;
};

}  // namespace

absl::StatusOr<bool> HasEigenvalueBelow(const Context& context, const LimitOperator& limit,
                                        double bound) {
  return Probe(context, limit).Run(bound);
}

}  // namespace limn
