// SPDX-License-Identifier: MIT
// What Krylov methods need of the interpolation equations L X = I: products, residuals and inner
// products, in the operator's slots. The three coordinates are one vector: methods see the operator
// three times beside itself, and what they find does not depend on the axes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/base/vec3.h"
#include "engine/scheme/limit_operator.h"

namespace limn {

class LinearSystem {
 public:
  // limit: L; points: I, in slots. Both must outlive this.
  LinearSystem(const Context& context, const LimitOperator& limit, absl::Span<const Vec3> points)
      : context_(context), limit_(limit), points_(points), values_(limit.face_value_count()) {}

  const Context& context() const { return context_; }
  std::size_t size() const { return points_.size(); }

  // out = L x.
  [[nodiscard]] absl::Status Product(absl::Span<const Vec3> x, absl::Span<Vec3> out) {
    LIMN_RETURN_IF_ERROR(limit_.FaceValues(context_, x, absl::MakeSpan(values_)));
    double unused = 0;
    return limit_.VisitLimits(
        context_, x.data(), values_.data(),
        [&](Index slot, const Vec3& limit) {
          out[slot] = limit;
          return 0.0;
        },
        &unused);
  }

  // residual = I - L x; *largest: its largest coordinate.
  [[nodiscard]] absl::Status Residual(absl::Span<const Vec3> x, absl::Span<Vec3> residual,
                                      double* largest) {
    LIMN_RETURN_IF_ERROR(limit_.FaceValues(context_, x, absl::MakeSpan(values_)));
    return limit_.VisitLimits(
        context_, x.data(), values_.data(),
        [&](Index slot, const Vec3& limit) {
          residual[slot] = points_[slot] - limit;
          return MaxAbs(residual[slot]);
        },
        largest);
  }

  // f(slot) for every slot.
  template <class F>
  [[nodiscard]] absl::Status ForEach(const F& f) const {
    return ParallelFor(context_, size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t slot = begin; slot < end; ++slot) f(slot);
    });
  }

  // *sum = sum of f(slot) over all slots, by fixed blocks: same bits for any number of threads.
  template <class F>
  [[nodiscard]] absl::Status Sum(const F& f, double* sum) const {
    std::vector<double> part((size() + kScanBlock - 1) / kScanBlock, 0);
    LIMN_RETURN_IF_ERROR(ParallelBlocks(context_, size(), kScanBlock,
                                        [&](std::size_t block, std::size_t begin, std::size_t end) {
                                          double total = 0;
                                          for (std::size_t i = begin; i < end; ++i) total += f(i);
                                          part[block] = total;
                                        }));
    *sum = 0;
    for (const double p : part) *sum += p;
    return absl::OkStatus();
  }

 private:
  const Context& context_;
  const LimitOperator& limit_;
  absl::Span<const Vec3> points_;
  Buffer<Vec3> values_;
};

// When a Krylov method ends, and what it tells after each product with L.
class KrylovProgress {
 public:
  // tolerance: of the residual's largest coordinate; products: at the most.
  KrylovProgress(const Context& context, double tolerance, std::uint32_t products, double scale)
      : context_(context), tolerance_(tolerance), products_(products), scale_(scale) {}

  bool spent() const { return done_ >= products_; }
  bool MetBy(double largest) const { return largest <= tolerance_; }
  std::uint32_t done() const { return done_; }

  void Count(double largest) {
    ++done_;
    context_.Report({.stage = "solve",
                     .fraction = static_cast<double>(done_) / products_,
                     .sweep = done_,
                     .update = largest / scale_});
  }

 private:
  const Context& context_;
  const double tolerance_;
  const std::uint32_t products_;
  const double scale_;
  std::uint32_t done_ = 0;
};

}  // namespace limn
