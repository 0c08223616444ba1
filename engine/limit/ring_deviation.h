// SPDX-License-Identifier: MIT
// How far the tessellation is from the limit surface around an extraordinary point. Used by
// engine/limit/chord_bound.h, which has the proof of what is done with it.
//
// Sector i of a ring is an endless sequence of regular patches: generation g has three of them,
// quarters of what was left of generation g - 1, 2^-g as large in the parameters. R_g is the union
// of all generations beyond g, over all sectors; R_0 is the whole ring. In coordinates relative to
// the extraordinary point and times 2^g the ring's points are F + E_g: F, the first harmonic, lies
// in the tangent plane and does not change; E_g is halved at each step, but for a factor that grows
// like g (Doo and Sabin 1978: eigenvalues 1/2 and 1/4).
#pragma once

#include <array>

#include "engine/limit/net_deviation.h"
#include "engine/limit/patch_ring.h"
#include "engine/limit/projected_cone.h"

namespace limn {

// Levels of tessellations that half-edges can number.
inline constexpr int kMaxChordLevel = 16;

// Whether a slide of that much stays on the piece of surface that the cone is about.
bool StaysWithin(const Deviation& deviation, const ProjectedCone& cone, double room);

// A bound of the distance between two surfaces whose points of the same parameter are `deviation`
// apart, where `room` is the distance in parameters from the piece in question to the end of the
// piece that the cone is about; see engine/limit/chord_bound.h.
double DistanceBound(const Deviation& deviation, const ProjectedCone& cone, double room);

struct RingBounds {
  // Of all derivatives in the ring; not valid where no cone holds them.
  ProjectedCone cone;
  // At level 2 + j, patches of the ring, or what is left of them of the first generation, are at
  // most 4^-j of this from their triangles, in parameters.
  Deviation deviation;
  // inside[j]: bound of the distance at level 2 + j of what is in R_1, for j >= 1.
  std::array<double, kMaxChordLevel> inside = {};
  // within_reach[j]: of the deviation at level 2 + j of all that is in R_0 and that the paths of
  // its first generation may get to.
  std::array<Deviation, kMaxChordLevel> within_reach = {};
};

// ring: of M^2; used up. deepest: the largest j that matters, less than kMaxChordLevel. Cost:
// linear in sides x deepest. Thread-safe.
RingBounds BoundRing(PatchRing* ring, int deepest);

}  // namespace limn
