// SPDX-License-Identifier: MIT
// The cones of a ring of patches, generation by generation. Used by engine/limit/ring_deviation.h,
// whose words these are.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/limit/net_deviation.h"
#include "engine/limit/patch_ring.h"
#include "engine/limit/projected_cone.h"
#include "engine/refine/harmonics.h"

namespace limn {

// From more sides on a sector is so narrow that its directions would hardly fit a cone.
inline constexpr std::size_t kMostSides = 64;

// The vertices of T^(k+1) in a sector's quad of T^k, in rows along v; the extraordinary point is
// the origin.
using NineVertices = std::array<std::array<Vec3, 3>, 3>;
NineVertices VerticesOf(const RefinedGrid& grid);

// A linear map that makes F round: t1 and t2, the first harmonic, become perpendicular to each
// other and of the same length; along the normal nothing changes, and neither do areas across it.
class RoundFrame {
 public:
  // normal: unit, along t1 x t2; or zero, when nothing may be asked.
  RoundFrame(const Harmonics& harmonics, const Vec3& normal);

  Vec3 Round(const Vec3& a) const {
    return Dot(a, first_) * axis_ + Dot(a, second_) * side_ + Dot(a, normal_) * normal_;
  }
  // Rounded, and without height.
  RefinedGrid Projected(RefinedGrid grid) const {
    for (auto& row : grid) {
      for (Vec3& p : row) p = Dot(p, first_) * axis_ + Dot(p, second_) * side_;
    }
    return grid;
  }
  // The largest factor of a length across the normal, here and back.
  double stretch() const { return stretch_; }
  // What a cone of rounded derivatives says of the derivatives themselves. With |p'| <= stretch |p|
  // and |p| <= stretch |p'|, the slope of a product p' x q' grows at most by that factor.
  ProjectedCone Back(ProjectedCone cone) const {
    if (!cone.valid()) return cone;
    cone.angle = std::atan(stretch_ * std::tan(cone.angle));
    cone.stretch /= stretch_;
    return cone;
  }
  const Vec3& normal() const { return normal_; }

 private:
  Vec3 normal_;
  Vec3 axis_ = {0, 0, 0};
  Vec3 side_ = {0, 0, 0};
  Vec3 first_ = {0, 0, 0};
  Vec3 second_ = {0, 0, 0};
  double stretch_ = 1;
};

// The cones of R_0, R_1, ... about the normal of the extraordinary point: for each quarter that of
// its derivatives, for each quad that of its triangles' edges. At a boundary, where both are mixed,
// a quad's edges go with all derivatives on it as well. These, and what is left in the end, are
// told by cones of directions, which are rounded first: whether two of them are parallel does not
// depend on it, and cones of a round F are the narrowest.
class RingCones {
 public:
  // first: refined grids of F, which has no height. Both must outlive this.
  RingCones(const RoundFrame& frame, const RingRefiner& first, const PatchRing& ring);

  // The next generation's refined grids, times 2^g relative to the extraordinary point.
  void AddGeneration(const RingRefiner& refiner);

  // One for each generation that was added; not valid for more than kMostSides or without normal.
  // remainder: bound of E from now on.
  [[nodiscard]] std::vector<ProjectedCone> Finish(const Deviation& remainder);

 private:
  // Directions along u and v of a piece of surface.
  struct ConePair {
    DirectionCone u;
    DirectionCone v;
    // Of the same axes.
    void Add(const ConePair& other);
  };
  // Those of a sector: of its three quarters of the next generation, and of its quad's edges, with
  // the axes of each quarter.
  struct SectorCones {
    std::array<ConePair, 3> quarter;
    std::array<ConePair, 3> quad;
    SectorCones Widened(double in_plane, double off_plane) const;
  };

  ProjectedCone ConeOf(const ConePair& pair) const;
  // Of the quarters and the quad.
  static void AddProducts(const RefinedGrid& grid, ProductCone* products);
  ProjectedCone Nothing() const;
  void WidenByParts(const SectorCones& cones, ProjectedCone* cone) const;
  void Mix(std::size_t g, std::vector<SectorCones>* beyond);
  RefinedGrid Rounded(RefinedGrid grid) const;
  SectorCones ConesOf(std::size_t i, const RefinedGrid& refined) const;
  ConePair NoneOf(std::size_t i, std::size_t row, std::size_t column) const;

  const RoundFrame& frame_;
  const RingRefiner& first_;
  // 0: no cones.
  std::size_t sectors_;
  bool mixed_;
  // Of each generation by itself, until Finish.
  std::vector<ProjectedCone> cones_;
  // By generation and sector; only to be mixed.
  std::vector<SectorCones> kept_;
};

}  // namespace limn
