// SPDX-License-Identifier: MIT
// How far the pieces R_g of a ring reach from the extraordinary point, in its plane. Used by
// engine/limit/ring_deviation.h, whose words these are.
//
// Let a disc around the extraordinary point hold the projection of R_i, and not touch that of the
// outer sides of R_o, o < i, neither of S nor of T^k. Then a segment between projections of points
// of R_i lies in the disc, and a path that is lifted from it and starts in R_o does not leave R_o.
// No angle and no length along the surface is needed for that. A path to a point outside of a disc
// around R_i does not get into R_i either, if it keeps its place in the plane.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/limit/patch_ring.h"
#include "engine/limit/ring_cones.h"

namespace limn {

// Distances are those of rounded points.
class RingReach {
 public:
  // frame: of the ring; must outlive this.
  RingReach(const RoundFrame& frame, const PatchRing& ring)
      : frame_(frame), sectors_(ring.sectors), at_boundary_(!ring.closed()) {}

  // The next generation's refined grids, times 2^g relative to the extraordinary point.
  void AddGeneration(const RingRefiner& refiner);

  // first: of F. slide: a bound of E's from now on, along the plane.
  void Finish(const RingRefiner& first, double slide);

  // Whether R_outer holds all paths between points of R_inner.
  bool Holds(int outer, int inner) const;

  // Of a ring at a boundary: the least e so that paths that stay above or below a point of
  // generation g do not get into R_e; a large number if there is none.
  int EndOfPaths(int g) const;

  bool at_boundary() const { return at_boundary_; }

 private:
  double RadiusOfQuarters(const RingRefiner& refiner) const;

  const RoundFrame& frame_;
  std::size_t sectors_;
  bool at_boundary_;
  // By generation, times 2^g: the radius of R_g, how near its outer sides come, and how near what
  // is in R_g but not in R_(g + 1).
  std::vector<double> radius_;
  std::vector<double> clear_;
  std::vector<double> near_;
};

}  // namespace limn
