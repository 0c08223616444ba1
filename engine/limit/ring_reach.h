// SPDX-License-Identifier: MIT
// How far the pieces R_g of a ring reach from the extraordinary point, in its plane. Used by
// engine/limit/ring_deviation.h, whose words these are.
//
// Let a disc around the extraordinary point hold the projection of R_i, and not touch that of the
// outer sides of R_o, o < i, neither of S nor of T^k. Then a segment between projections of points
// of R_i lies in the disc, and a path that is lifted from it and starts in R_o does not leave R_o.
// No angle and no length along the surface is needed for that.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/limit/patch_ring.h"
#include "engine/limit/ring_cones.h"

namespace limn {

// Distances are those of rounded points. For rings without boundary.
class RingReach {
 public:
  // frame: of a ring with a normal; must outlive this.
  explicit RingReach(const RoundFrame& frame) : frame_(frame) {}

  // The next generation's refined grids, times 2^g relative to the extraordinary point.
  void AddGeneration(const RingRefiner& refiner, std::size_t sectors);

  // first: of F. slide: a bound of E's from now on, along the plane.
  void Finish(const RingRefiner& first, std::size_t sectors, double slide);

  // Whether R_outer holds all paths between points of R_inner.
  bool Holds(std::size_t outer, std::size_t inner) const;

 private:
  double RadiusOf(const RingRefiner& refiner, std::size_t sectors) const;

  const RoundFrame& frame_;
  // By generation, times 2^g: the radius of R_g, and how near its outer sides come.
  std::vector<double> radius_;
  std::vector<double> clear_;
};

}  // namespace limn
