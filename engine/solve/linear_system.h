// SPDX-License-Identifier: MIT
// What Krylov methods need of the interpolation equations L X = I: products, residuals and inner
// products, in the operator's slots. The three coordinates are one vector: methods see the operator
// three times beside itself, and what they find does not depend on the axes.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/base/vec3.h"
#include "engine/stencil/limit_operator.h"

namespace limn {

// Lengths as parts of a scale, by their squares, which neither over- nor underflow where the scale
// is a mesh's.
class RelativeLength {
 public:
  // scale: greater than 0.
  explicit RelativeLength(double scale) : inverse_(1 / scale) {}
  double Square(const Vec3& a) const {
    const Vec3 part = inverse_ * a;
    return Dot(part, part);
  }

 private:
  double inverse_;
};

class LinearSystem {
 public:
  // limit: L; points: I, in slots; scale: what residuals are parts of; values: room for
  // limit.face_value_count() face values. All must outlive this.
  LinearSystem(const Context& context, const LimitOperator& limit, absl::Span<const Vec3> points,
               double scale, absl::Span<Vec3> values)
      : context_(context), limit_(limit), points_(points), length_(scale), values_(values) {}

  const Context& context() const { return context_; }
  std::size_t size() const { return points_.size(); }
  const RelativeLength& length() const { return length_; }

  // out = L x.
  [[nodiscard]] absl::Status Product(absl::Span<const Vec3> x, absl::Span<Vec3> out) {
    LIMN_RETURN_IF_ERROR(limit_.FaceValues(context_, x, values_));
    double unused = 0;
    return limit_.VisitLimits(
        context_, x.data(), values_.data(),
        [&](Index slot, const Vec3& limit) {
          out[slot] = limit;
          return 0.0;
        },
        &unused);
  }

  // residual = I - L x; *largest: the greatest of its lengths over the scale, infinite where one is
  // no number.
  [[nodiscard]] absl::Status Residual(absl::Span<const Vec3> x, absl::Span<Vec3> residual,
                                      double* largest) {
    LIMN_RETURN_IF_ERROR(limit_.FaceValues(context_, x, values_));
    LIMN_RETURN_IF_ERROR(limit_.VisitLimits(
        context_, x.data(), values_.data(),
        [&](Index slot, const Vec3& limit) {
          residual[slot] = points_[slot] - limit;
          return IsFinite(residual[slot]) ? length_.Square(residual[slot])
                                          : std::numeric_limits<double>::infinity();
        },
        largest));
    *largest = std::sqrt(*largest);
    return absl::OkStatus();
  }

  // x = I.
  [[nodiscard]] absl::Status Reset(absl::Span<Vec3> x) const {
    return ForEach([&](std::size_t slot) { x[slot] = points_[slot]; });
  }

  // f(slot) for every slot.
  template <class F>
  [[nodiscard]] absl::Status ForEach(const F& f) const {
    return ParallelFor(context_, size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) f(slot);
    });
  }

  // *sum = sum of f(slot) over all slots; same bits for any number of threads.
  template <class F>
  [[nodiscard]] absl::Status Sum(const F& f, double* sum) const {
    return ParallelSum(context_, size(), f, sum);
  }

 private:
  const Context& context_;
  const LimitOperator& limit_;
  absl::Span<const Vec3> points_;
  const RelativeLength length_;
  absl::Span<Vec3> values_;
};

// When a Krylov method ends, and what it tells after each step.
class KrylovProgress {
 public:
  // tolerance: of the longest residual; steps: at the most.
  KrylovProgress(const Context& context, double tolerance, std::uint32_t steps)
      : context_(context), tolerance_(tolerance), steps_(steps) {}

  bool ForbidsStep() const { return done_ >= steps_; }
  bool MetBy(double largest) const { return largest <= tolerance_; }
  std::uint32_t done() const { return done_; }

  void Count(double largest) {
    ++done_;
    context_.Report({.stage = "solve",
                     .fraction = static_cast<double>(done_) / steps_,
                     .sweep = done_,
                     .update = largest});
  }

 private:
  const Context& context_;
  const double tolerance_;
  const std::uint32_t steps_;
  std::uint32_t done_ = 0;
};

}  // namespace limn
