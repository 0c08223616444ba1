// SPDX-License-Identifier: MIT
// How much a Doo-Sabin surface bends: the integral of the squared mean curvature H^2 over its area
// (Willmore's energy). It has no unit: scaled surfaces have the same. A sphere has 4 pi, a torus
// with the radii R > r has pi^2 q^2 / sqrt(q^2 - 1) with q = R / r, a plane 0.
#pragma once

#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/limit/biquadratic.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

// The energy of one patch by 2 x 2 Gauss points. Where the derivatives span no area to rounding, a
// point counts as 0. Squares of the net's derivatives must not over- or underflow. Thread-safe.
double PatchBendingEnergy(const BiquadraticNet& net);

// Measures surfaces of the same connectivity.
//
// Quadrature: the patches of M^2. Where the four faces around a control point are quads, its patch
// is one biquadratic polynomial, integrated by PatchBendingEnergy; refining further changes the sum
// by the error of Gauss's rule alone. Around an extraordinary point a patch is an endless sequence
// of regular ones, three at each level: kBendingRings levels are integrated like that, and what
// remains is taken as a third of the last one, as curvature stays bounded there but for a logarithm
// and areas fall to a quarter. Twelve levels instead of four change the sum by up to 0.3 %. Where
// the surface has a cusp or a
// sharp fold there is no finite energy; a large number comes out, which only says so.
inline constexpr int kBendingRings = 4;

class BendingEnergyMeter {
 public:
  // mesh: T^0, from HalfEdgeMesh::Build; must outlive the meter. Errors: LIMIT_EXCEEDED where
  // numbers of T^1 do not fit, CANCELLED, DEADLINE_EXCEEDED. Cost: a quad split.
  [[nodiscard]] static absl::StatusOr<BendingEnergyMeter> Make(const Context& context,
                                                               const HalfEdgeMesh& mesh);

  // corners: M^1, one per half-edge, of any size up to 1e100. boundary: its curve; null or empty
  // for closed meshes. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: a refinement, and up to 1 us per
  // control point of M^2 where all faces are extraordinary, 0.1 us where none are, in parallel.
  // Same bits for any number of threads. Not thread-safe: buffers are kept for the next call.
  [[nodiscard]] absl::StatusOr<double> Measure(const Context& context,
                                               absl::Span<const Vec3> corners,
                                               const BoundaryCurve* boundary);

  // What was measured last: the energies of the patches of M^2, of which corner h of the mesh has
  // those from 4 h on.
  absl::Span<const double> patches() const { return energy_; }

 private:
  BendingEnergyMeter(const HalfEdgeMesh& mesh, HalfEdgeMesh split, ExtraordinaryFans fans)
      : mesh_(mesh), split_(std::move(split)), fans_(std::move(fans)) {}

  absl::Status MeasurePatches(const Context& context, double factor);
  absl::Status MeasureBoundary(const Context& context, double factor,
                               const BoundaryCurve& boundary);
  absl::StatusOr<double> Total(const Context& context) const;

  const HalfEdgeMesh& mesh_;
  HalfEdgeMesh split_;
  ExtraordinaryFans fans_;
  Buffer<Vec3> refined_;
  Buffer<double> energy_;
};

// The same for one surface. Thread-safe.
[[nodiscard]] absl::StatusOr<double> BendingEnergy(const Context& context,
                                                   const DooSabinSurface& surface);

}  // namespace limn
