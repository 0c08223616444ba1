// SPDX-License-Identifier: MIT
// The cones of a ring of patches, generation by generation. Used by engine/limit/ring_deviation.h,
// whose words these are.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "engine/base/vec3.h"
#include "engine/limit/net_deviation.h"
#include "engine/limit/patch_ring.h"
#include "engine/limit/projected_cone.h"

namespace limn {

// From more sides on a sector is so narrow that its directions would hardly fit a cone.
inline constexpr std::size_t kMostSides = 64;

// The vertices of T^(k+1) in a sector's quad of T^k, in rows along v; the extraordinary point is
// the origin.
using NineVertices = std::array<std::array<Vec3, 3>, 3>;
NineVertices VerticesOf(const RefinedGrid& grid);

// The cones of R_0, R_1, ... about the normal of the extraordinary point: for each quarter that of
// its derivatives, for each quad that of its triangles' edges. At a boundary, where both are mixed,
// a quad's edges go with all derivatives on it as well.
class RingCones {
 public:
  // normal: unit or zero. first: refined grids of F, which has no height; must outlive this.
  RingCones(const Vec3& normal, const RingRefiner& first, const PatchRing& ring);

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

  ProjectedCone Nothing() const;
  void WidenByParts(const SectorCones& cones, ProjectedCone* cone) const;
  void Mix(std::size_t g, std::vector<SectorCones>* beyond);
  SectorCones ConesOf(std::size_t i, const RefinedGrid& grid) const;
  ConePair NoneOf(std::size_t i, std::size_t row, std::size_t column) const;

  Vec3 normal_;
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
