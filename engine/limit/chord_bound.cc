// SPDX-License-Identifier: MIT
#include "engine/limit/chord_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/limit/chord_coarse.h"
#include "engine/limit/patch_cones.h"
#include "engine/limit/patch_ring.h"
#include "engine/mesh/quad_split.h"
#include "engine/refine/doo_sabin_refine.h"

namespace limn {
namespace {

constexpr std::size_t kPatchBlock = 4096;
constexpr std::size_t kRingBlock = 64;

// Rounding of the tessellation's points, in units in the last place of the largest coordinate.
constexpr double kRounding = 64;

// Levels from 2 on; [j] for level 2 + j.
using Fine = std::array<double, kMaxChordLevel>;
using DeviationByLevel = std::array<Deviation, kMaxChordLevel>;

void Widen(const Fine& other, Fine* fine) {
  for (std::size_t j = 0; j < fine->size(); ++j) (*fine)[j] = std::max((*fine)[j], other[j]);
}

// How far the quadratic curve from a to c with the control point b is from its chord, across it; at
// the same parameter where the curve turns back. Pieces of half the length have a quarter of it.
double CurveDeviation(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 first = b - a;
  const Vec3 second = c - b;
  const Vec3 change = second - first;
  // The second derivative is 2 change, and an eighth of it the distance in the middle.
  if (!(Dot(first, second) > 0)) return 0.25 * Norm(change);
  // Directions along the curve run from `first` to `second`; across any of them the part of
  // `change` is |first x second| / |direction|.
  const double along = std::clamp(-Dot(first, change) / Dot(change, change), 0.0, 1.0);
  const double shortest = Dot(change, change) > 0 ? Norm(first + along * change) : Norm(first);
  return std::min(0.25 * Norm(change), 0.25 * Norm(Cross(first, second)) / shortest);
}

class Bounder {
 public:
  Bounder(const Context& context, const DooSabinSurface& surface, int finest)
      : context_(context), surface_(surface), finest_(finest) {}

  absl::StatusOr<std::vector<double>> Run() {
    LIMN_RETURN_IF_ERROR(RefineOnce());
    LIMN_RETURN_IF_ERROR(BoundPatches());
    LIMN_RETURN_IF_ERROR(BoundRings());
    LIMN_RETURN_IF_ERROR(MeasureCurve());
    LIMN_RETURN_IF_ERROR(BoundFineLevels());
    LIMN_ASSIGN_OR_RETURN(const CoarseChords coarse,
                          BoundCoarseLevels(context_, {.base = surface_.mesh,
                                                       .split = *split_,
                                                       .fans = fans_,
                                                       .corners = refined_,
                                                       .boundary = boundary_}));
    return Assemble(coarse);
  }

 private:
  int deepest() const { return std::max(0, finest_ - 2); }

  absl::Status RefineOnce() {
    const HalfEdgeMesh& mesh = surface_.mesh;
    LIMN_ASSIGN_OR_RETURN(fans_, FindExtraordinaryFans(context_, mesh));
    refined_.resize(4 * mesh.half_edge_count());
    LIMN_RETURN_IF_ERROR(RefineDooSabin(
        context_, {.mesh = mesh, .fans = fans_, .k = 1, .boundary = &surface_.boundary},
        surface_.corners, absl::MakeSpan(refined_)));
    LIMN_ASSIGN_OR_RETURN(boundary_, RefineBoundary(context_, mesh, surface_.boundary));
    LIMN_ASSIGN_OR_RETURN(split_, SplitIntoQuads(context_, mesh));
    return ParallelMax(
        context_, refined_.size(), 0,
        [&](std::size_t begin, std::size_t end) {
          double largest = 0;
          for (std::size_t h = begin; h < end; ++h)
            largest = std::max(largest, MaxAbs(refined_[h]));
          return largest;
        },
        &size_);
  }

  // Those whose faces are quads without ghosts.
  absl::Status BoundPatches() {
    patches_.resize(refined_.size());
    return ParallelFor(context_, refined_.size(), [&](std::size_t begin, std::size_t end) {
      BiquadraticNet net;
      for (std::size_t h = begin; h < end; ++h) {
        if (RegularNet(*split_, refined_.data(), static_cast<Index>(h), &net)) {
          patches_[h] = BoundOf(net);
        }
      }
    });
  }
  static PatchBound BoundOf(const BiquadraticNet& net) {
    const BiquadraticJet middle = EvaluateBiquadratic(net, 0.5, 0.5);
    const Vec3 normal = UnitCross(middle.du, middle.dv, MaxAbs(net[1][1]));
    const NetDerivatives derivatives = DerivativesOf(net, 1);
    ProductCone products(normal);
    products.Add(derivatives.u, derivatives.v);
    return {products.Cone(), DeviationOf(net, normal).sum()};
  }

  // Those around extraordinary points and along the boundary.
  absl::Status BoundRings() {
    LIMN_RETURN_IF_ERROR(MaxOverBlocks(
        fans_.vertex.size(), kRingBlock,
        [&](std::size_t begin, std::size_t end, Fine* fine) {
          PatchRing ring;
          DeviationByLevel within_reach;
          for (std::size_t i = begin; i < end; ++i) {
            GatherRing(*split_, refined_.data(),
                       absl::MakeConstSpan(fans_.corner)
                           .subspan(fans_.begin[i], fans_.begin[i + 1] - fans_.begin[i]),
                       &ring);
            Widen(BoundOneRing(&ring, &within_reach), fine);
          }
        },
        &inside_));
    boundary_reach_.resize(boundary_.size());
    return MaxOverBlocks(
        boundary_.size(), kRingBlock,
        [&](std::size_t begin, std::size_t end, Fine* fine) {
          BoundaryFace face;
          PatchRing ring;
          for (std::size_t i = begin; i < end; ++i) {
            GatherBoundaryRing(*split_, boundary_, refined_.data(), static_cast<Index>(i), &face,
                               &ring);
            boundary_reach_[i] = {};
            Widen(BoundOneRing(&ring, &boundary_reach_[i]), fine);
          }
        },
        &inside_boundary_);
  }
  // body(begin, end, &fine) widens `fine`, block by block.
  template <class Body>
  absl::Status MaxOverBlocks(std::size_t n, std::size_t block_size, const Body& body,
                             Fine* result) {
    std::vector<Fine> partial((n + block_size - 1) / block_size, Fine{});
    LIMN_RETURN_IF_ERROR(ParallelBlocks(context_, n, block_size,
                                        [&](std::size_t block, std::size_t begin, std::size_t end) {
                                          body(begin, end, &partial[block]);
                                        }));
    for (const Fine& part : partial) Widen(part, result);
    return absl::OkStatus();
  }
  // within_reach: written for irregular rings only.
  Fine BoundOneRing(PatchRing* ring, DeviationByLevel* within_reach) {
    Fine inside = {};
    if (ring->regular()) {
      for (std::size_t i = 0; i < ring->sectors; ++i) {
        patches_[ring->corner[i]] = BoundOf(ring->Net(i));
      }
      return inside;
    }
    const RingBounds bounds = BoundRing(ring, deepest());
    for (const Index h : ring->corner) patches_[h] = {bounds.cone, bounds.deviation};
    *within_reach = bounds.within_reach;
    return bounds.inside;
  }

  absl::Status MeasureCurve() {
    return ParallelMax(
        context_, boundary_.size(), 0,
        [&](std::size_t begin, std::size_t end) {
          double largest = 0;
          for (std::size_t i = begin; i < end; ++i) {
            const Vec3& from = boundary_.centre[i];
            const Vec3& to = boundary_.centre[boundary_.next[i]];
            const Vec3 middle = 0.5 * (boundary_.start[i] + boundary_.end[i]);
            largest = std::max(largest, CurveDeviation(from, boundary_.start[i], middle));
            largest = std::max(largest, CurveDeviation(middle, boundary_.end[i], to));
          }
          return largest;
        },
        &curve_);
  }

  // The patches of M^2 with the cones of all patches around them.
  absl::Status BoundFineLevels() {
    LIMN_ASSIGN_OR_RETURN(const PatchCones cones, PatchCones::Make(context_, *split_, patches_));
    LIMN_RETURN_IF_ERROR(MaxOverBlocks(
        patches_.size(), kPatchBlock,
        [&](std::size_t begin, std::size_t end, Fine* fine) {
          for (std::size_t h = begin; h < end; ++h) {
            WidenByPatch(cones.Around(static_cast<Index>(h)), fine);
          }
        },
        &fine_));
    // Around the boundary's extraordinary vertices again, where what is in R_1 is within reach.
    LIMN_RETURN_IF_ERROR(MaxOverBlocks(
        boundary_.size(), kRingBlock,
        [&](std::size_t begin, std::size_t end, Fine* fine) {
          const QuadWalk walk(*split_);
          for (std::size_t i = begin; i < end; ++i) {
            for (Index h = boundary_.half_edge[i]; h != kNoIndex;
                 h = RotateCcw(walk, split_->twin(), h)) {
              WidenByBoundaryPatch(cones.Around(h), boundary_reach_[i], fine);
            }
          }
        },
        &fine_));
    for (std::size_t j = 0; j < fine_.size(); ++j) {
      const double curve = std::ldexp(curve_, -2 * static_cast<int>(j));
      fine_[j] = std::max({fine_[j], inside_[j], inside_boundary_[j] + curve});
    }
    return absl::OkStatus();
  }
  void WidenByPatch(const PatchCones::Surroundings& patch, Fine* fine) const {
    if (patch.at_boundary) {
      static constexpr DeviationByLevel kNothing = {};
      return WidenByBoundaryPatch(patch, kNothing, fine);
    }
    const double first = DistanceBound(patch.deviation, patch.cone, 1);
    // Once the cone counts, or if it never does, every level has a quarter of the one before.
    const bool settled = !patch.cone.valid() || StaysWithin(patch.deviation, patch.cone, 1);
    for (int j = 0; j <= deepest(); ++j) {
      const double part = std::ldexp(1, -2 * j);
      double& level = (*fine)[static_cast<std::size_t>(j)];
      level = std::max(
          level, settled ? part * first : DistanceBound(part * patch.deviation, patch.cone, 1));
    }
  }
  // within_reach: by level, of what is around beside the patches' own deviations. These hold up to
  // half way into the patches around: beyond may be an R_1.
  void WidenByBoundaryPatch(const PatchCones::Surroundings& patch,
                            const DeviationByLevel& within_reach, Fine* fine) const {
    for (int j = 0; j <= deepest(); ++j) {
      const auto at = static_cast<std::size_t>(j);
      const double part = std::ldexp(1, -2 * j);
      Deviation deviation = part * patch.deviation;
      deviation.Widen(within_reach[at]);
      (*fine)[at] =
          std::max((*fine)[at], DistanceBound(deviation, patch.cone, 0.5) + part * curve_);
    }
  }

  std::vector<double> Assemble(const CoarseChords& coarse) const {
    const double rounding =
        kRounding * std::numeric_limits<double>::epsilon() * (size_ + MaxAbs(surface_.origin()));
    std::vector<double> bounds;
    const double second = fine_[0] + rounding;
    const double first = second + coarse.first_to_second;
    bounds.push_back(first + coarse.polygons_to_first);
    bounds.push_back(first);
    for (int k = 2; k <= finest_; ++k) {
      bounds.push_back(fine_[static_cast<std::size_t>(k - 2)] + rounding);
    }
    bounds.resize(static_cast<std::size_t>(finest_) + 1);
    return bounds;
  }

  const Context& context_;
  const DooSabinSurface& surface_;
  int finest_;
  // T^1, M^2 and its boundary.
  std::optional<HalfEdgeMesh> split_;
  ExtraordinaryFans fans_;
  Buffer<Vec3> refined_;
  BoundaryCurve boundary_;
  double size_ = 0;
  Buffer<PatchBound> patches_;
  Fine inside_ = {};
  Fine inside_boundary_ = {};
  // Of the ring at each vertex of T^1 on the boundary; zeros where it is regular.
  Buffer<DeviationByLevel> boundary_reach_;
  double curve_ = 0;
  Fine fine_ = {};
};

}  // namespace

absl::StatusOr<std::vector<double>> ChordBounds(const Context& context,
                                                const DooSabinSurface& surface, int finest) {
  return Bounder(context, surface, std::min(finest, kMaxChordLevel)).Run();
}

absl::StatusOr<ChordLevel> ChooseLevel(const Context& context, const DooSabinSurface& surface,
                                       const ChordWish& wish) {
  const double tolerance = wish.tolerance;
  if (!(tolerance > 0) || !std::isfinite(tolerance)) {
    return MakeError(absl::StrCat("the chord tolerance is ", tolerance),
                     {.reason = Reason::kInvalidOption,
                      .field = "surface.chord_tolerance",
                      .remedy = "It must be greater than 0 and finite"});
  }
  constexpr int kUsual = 4;
  const int most = static_cast<int>(std::min<std::uint32_t>(
      {context.limits().max_level, wish.finest, std::uint32_t{kMaxChordLevel}}));
  // Above what six digits round off.
  constexpr double kRoundedUp = 1.00001;
  double best = 0;
  for (const int finest : {std::min(kUsual, most), most}) {
    LIMN_ASSIGN_OR_RETURN(const std::vector<double> bounds, ChordBounds(context, surface, finest));
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      if (bounds[k] <= tolerance) {
        return ChordLevel{.level = static_cast<std::uint32_t>(k), .bound = bounds[k]};
      }
    }
    best = *std::min_element(bounds.begin(), bounds.end());
  }
  return MakeError(
      absl::StrCat("no level up to ", most, " is guaranteed to be within ", tolerance,
                   " of the limit surface"),
      {.reason = Reason::kLimitExceeded,
       .field = "surface.chord_tolerance",
       .remedy = absl::StrCat("The smallest tolerance that can be met is ", best * kRoundedUp)});
}

}  // namespace limn
