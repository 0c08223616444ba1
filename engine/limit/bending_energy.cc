// SPDX-License-Identifier: MIT
#include "engine/limit/bending_energy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/limit/patch_ring.h"
#include "engine/mesh/quad_split.h"

namespace limn {
namespace {

constexpr std::size_t kPatchBlock = 2048;

// Gauss and Legendre's rule on [0, 1], exact to degree 3: the mean of the values at these points.
constexpr double kOff = 0.28867513459481288225;  // 1 / sqrt(12)
constexpr std::array<double, 2> kGauss = {0.5 - kOff, 0.5 + kOff};

// H^2 dA, with H = (E N - 2 F M + G L) / (2 (E G - F^2)).
double Density(const BiquadraticJet& jet) {
  const Vec3 normal = Cross(jet.du, jet.dv);
  const double e = Dot(jet.du, jet.du);
  const double f = Dot(jet.du, jet.dv);
  const double g = Dot(jet.dv, jet.dv);
  const double area = Dot(normal, normal);
  if (!(area > kRoundingNoise * kRoundingNoise * e * g)) return 0;
  const double twice =
      e * Dot(normal, jet.dvv) - 2 * f * Dot(normal, jet.duv) + g * Dot(normal, jet.duu);
  const double ratio = twice / area;
  return 0.25 * ratio * ratio / std::sqrt(area);
}

// Nets are taken relative to their middle and at a size near 1.
class Scale {
 public:
  explicit Scale(double factor) : factor_(factor) {}
  double PatchEnergy(BiquadraticNet net) const {
    const Vec3 middle = net[1][1];
    for (auto& row : net) {
      for (Vec3& p : row) p = factor_ * (p - middle);
    }
    return PatchBendingEnergy(net);
  }

 private:
  double factor_;
};

// Writes the energies of the ring's patches, which it uses up: energy[h] for corner h of T^1.
void MeasureRing(const Scale& scale, PatchRing* ring, absl::Span<double> energy) {
  if (ring->regular()) {
    for (std::size_t i = 0; i < ring->sectors; ++i) {
      energy[ring->corner[i]] = scale.PatchEnergy(ring->Net(i));
    }
    return;
  }
  for (std::size_t i = 0; i < ring->sectors; ++i) energy[ring->corner[i]] = 0;
  RingRefiner refiner(ring);
  for (int level = 0; level < kBendingRings; ++level) {
    if (level > 0) refiner.Advance();
    const double factor = level + 1 < kBendingRings ? 1 : 4.0 / 3;
    for (std::size_t i = 0; i < ring->sectors; ++i) {
      const RefinedGrid& grid = refiner.grid(i);
      const double here = scale.PatchEnergy(QuarterNet(grid, 0, 1)) +
                          scale.PatchEnergy(QuarterNet(grid, 1, 0)) +
                          scale.PatchEnergy(QuarterNet(grid, 1, 1));
      energy[ring->corner[i]] += factor * here;
    }
  }
}

}  // namespace

double PatchBendingEnergy(const BiquadraticNet& net) {
  double sum = 0;
  for (const double v : kGauss) {
    for (const double u : kGauss) sum += Density(EvaluateBiquadratic(net, u, v));
  }
  return 0.25 * sum;
}

absl::StatusOr<BendingEnergyMeter> BendingEnergyMeter::Make(const Context& context,
                                                            const HalfEdgeMesh& mesh) {
  LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh split, SplitIntoQuads(context, mesh));
  LIMN_ASSIGN_OR_RETURN(ExtraordinaryFans fans, FindExtraordinaryFans(context, mesh));
  return BendingEnergyMeter(mesh, std::move(split), std::move(fans));
}

absl::StatusOr<double> BendingEnergyMeter::Measure(const Context& context,
                                                   absl::Span<const Vec3> corners,
                                                   const BoundaryCurve* boundary) {
  refined_.resize(4 * mesh_.half_edge_count());
  LIMN_RETURN_IF_ERROR(RefineDooSabin(context,
                                      {.mesh = mesh_, .fans = fans_, .k = 1, .boundary = boundary},
                                      corners, absl::MakeSpan(refined_)));
  double size = 0;
  LIMN_RETURN_IF_ERROR(ParallelMax(
      context, corners.size(), 0,
      [&](std::size_t begin, std::size_t end) {
        double largest = 0;
        for (std::size_t h = begin; h < end; ++h) {
          largest = std::max(largest, MaxAbs(corners[h] - corners[0]));
        }
        return largest;
      },
      &size));
  const double factor = size > 0 ? std::ldexp(1, -std::ilogb(size)) : 1;
  energy_.resize(refined_.size());
  LIMN_RETURN_IF_ERROR(MeasurePatches(context, factor));
  if (boundary != nullptr && !boundary->empty()) {
    LIMN_RETURN_IF_ERROR(MeasureBoundary(context, factor, *boundary));
  }
  return Total(context);
}

// Around vertices of T^1 that are not on its boundary.
absl::Status BendingEnergyMeter::MeasurePatches(const Context& context, double factor) {
  const Scale scale(factor);
  const absl::Span<double> energy = absl::MakeSpan(energy_);
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, refined_.size(), [&](std::size_t begin, std::size_t end) {
        BiquadraticNet net;
        for (std::size_t h = begin; h < end; ++h) {
          if (RegularNet(split_, refined_.data(), static_cast<Index>(h), &net)) {
            energy[h] = scale.PatchEnergy(net);
          }
        }
      }));
  return ParallelFor(context, fans_.vertex.size(), [&](std::size_t begin, std::size_t end) {
    PatchRing ring;
    for (std::size_t i = begin; i < end; ++i) {
      GatherRing(split_, refined_.data(),
                 absl::MakeConstSpan(fans_.corner)
                     .subspan(fans_.begin[i], fans_.begin[i + 1] - fans_.begin[i]),
                 &ring);
      MeasureRing(scale, &ring, energy);
    }
  });
}

// The patches at boundary vertices, whose faces ghosts complete.
absl::Status BendingEnergyMeter::MeasureBoundary(const Context& context, double factor,
                                                 const BoundaryCurve& boundary) {
  const Scale scale(factor);
  LIMN_ASSIGN_OR_RETURN(const BoundaryCurve curve, RefineBoundary(context, mesh_, boundary));
  return ParallelFor(context, curve.size(), [&](std::size_t begin, std::size_t end) {
    PatchRing ring;
    BoundaryFace face;
    for (std::size_t i = begin; i < end; ++i) {
      GatherBoundaryRing(split_, curve, refined_.data(), static_cast<Index>(i), &face, &ring);
      MeasureRing(scale, &ring, absl::MakeSpan(energy_));
    }
  });
}

absl::StatusOr<double> BendingEnergyMeter::Total(const Context& context) const {
  double total = 0;
  LIMN_RETURN_IF_ERROR(ParallelSum(
      context, energy_.size(), [&](std::size_t h) { return energy_[h]; }, &total));
  return total;
}

absl::StatusOr<double> BendingEnergy(const Context& context, const DooSabinSurface& surface) {
  LIMN_ASSIGN_OR_RETURN(BendingEnergyMeter meter, BendingEnergyMeter::Make(context, surface.mesh));
  return meter.Measure(context, surface.corners, &surface.boundary);
}

}  // namespace limn
