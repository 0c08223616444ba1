// SPDX-License-Identifier: MIT
// A guaranteed bound of the distance between a Doo-Sabin limit surface S and its tessellation T^k
// (engine/limit/tessellation.h), each quad of T^k split by either diagonal: every point of S is
// that near to some point of T^k, and every point of T^k to some point of S. All levels are bounded
// from M^2 alone; nothing finer is built. Sources: none for the whole; the parts are cited.
//
// Parametric bound. The points of a patch and of its quad at the same parameter differ by e. On a
// regular patch e is bounded by second differences, which fall to exactly a quarter at each level
// (engine/limit/net_deviation.h). On an irregular patch T^k differs from T^(k+1) by at most delta_k
// = the largest difference at the vertices of T^(k+1), since both are bilinear on its quads; so the
// bounds of the three regular quarters and of what is left add up, until the rest is bounded by its
// first harmonic, which halves at each level, and by the hull of the remaining points
// (engine/limit/ring_deviation.h).
//
// Geometric bound. e is mostly a slide along the surface, which is no distance: on a plane S and
// T^k are the same set. Let n be a direction, P the projection along it, e = (height along n, slide
// across n), D the patch and the patches around it. Suppose all products of a derivative of S along
// u with one along v, also of different points of a patch, make an angle of at most t < 90 degrees
// with n, on D (engine/limit/projected_cone.h). The edges of T^k are means of derivatives: the
// same holds for its triangles, and for H_r = (1 - r) T^k + r S, 0 <= r <= 1. So P H_r keeps
// orientations, which makes it open and discrete, and paths can be lifted through it (Floyd 1950;
// Rickman 1973). Let x be a point of the patch. Lift the segment from P T^k(x) to P S(x) through
// P T^k, from x on: in the parameters its lift is at most slide / (cos t stretch) long; if that is
// less than 1 it stays on D, as all other ends of the patches around are at least 1 away. On T^k
// the height changes by at most tan t slide along it, and where it ends T^k is right above or below
// S(x): at a distance of at most height + tan t slide. From T^k to S it is the same.
//   At a boundary the lift may meet the end of the surface. There, follow the z(r) with P H_r(z(r))
// = P S(x) from z(1) = x instead, and take the largest e of all patches in D: H_r(z(r)) moves along
// n only, by at most height + tan t slide in all. Either it gets to r = 0, a point of T^k, or z(r)
// meets the end. Then H_r(z) lies between a point of the boundary curve and that of its chord at
// the same parameter. Where the curve turns by less than 90 degrees along the chord, this is at
// most as far from the chord, and from the curve, as these are from each other across the chord,
// which is added. From T^k to S, r runs from 0 to 1.
//   The smaller one of both bounds counts, patch by patch. Near an extraordinary point n is the
// normal there, and D shrinks with the level, so that slide ~ 2^-k, tan t ~ 2^-k, height ~ 4^-k.
// There discs in the plane say better than lengths of lifts which patches a path may get to
// (engine/limit/ring_reach.h); so e need not be taken where the slide is larger.
//
// The bound is one of the largest distance, and above it by a factor of 1.2 to 9 on meshes that are
// not far from regular, and of about 10 on rough ones, on which it counts what a patch with all its
// neighbours might do; near a boundary vertex of six faces by 40. From level 5 or so on it falls to
// a quarter at each level, as the distance does; to a half around points of more than 64 faces.
//
// Level 1: T^1 against T^2 in the same way, plus the bound of level 2. Level 0: the faces are
// polygons; see engine/limit/chord_coarse.h.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/limit/ring_deviation.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

// bounds[k] for T^k, k = 0 .. finest <= kMaxChordLevel, in model units. The finer, the more is
// known about extraordinary points: the same level's bound may then be a little smaller. A few
// units in the last place of the largest coordinate are added, for the rounding of T^k itself: so
// plane surfaces have no 0.
//
// surface: M^1. Errors: LIMIT_EXCEEDED where numbers of T^1 do not fit, CANCELLED,
// DEADLINE_EXCEEDED. Cost: a refinement and two passes over M^2, about 0.5 us a control point, 2 to
// 4 us around extraordinary points, the more the higher `finest`; 280 bytes per point of M^2. Same
// bits for any number of threads. Thread-safe.
[[nodiscard]] absl::StatusOr<std::vector<double>> ChordBounds(const Context& context,
                                                              const DooSabinSurface& surface,
                                                              int finest);

struct ChordLevel {
  std::uint32_t level = 0;
  // Of the distance at that level.
  double bound = 0;
};

struct ChordWish {
  // In model units.
  double tolerance = 0;
  // The finest level that may be chosen; the context's max_level holds too.
  std::uint32_t finest = kMaxChordLevel;
};

// The smallest level whose bound is at most the tolerance. Errors: INVALID_OPTION where the
// tolerance is not above 0 and finite; LIMIT_EXCEEDED, naming surface.chord_tolerance and the
// smallest tolerance that can be met, where no level does; and those of ChordBounds, which is asked
// for a few levels first, and for all of them only where these do not do.
[[nodiscard]] absl::StatusOr<ChordLevel> ChooseLevel(const Context& context,
                                                     const DooSabinSurface& surface,
                                                     const ChordWish& wish);

}  // namespace limn
