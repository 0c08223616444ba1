// SPDX-License-Identifier: MIT
#include "server/job_cost.h"

#include <algorithm>
#include <cmath>

namespace limn {
namespace {

// Nanoseconds.
constexpr double kPerCorner = 100;
constexpr double kPerCornerOfASweep = 4;
constexpr double kPerCornerOfRepair = 300;
constexpr double kPerSurfaceCorner = 15;
constexpr double kPerConstraint = 2000;
// On the surface: a region is looked for, and where constraints are close many are met together.
constexpr double kPerBlend = 20'000;
constexpr double kPerSurfaceConstraint = 500'000;
constexpr double kPerRegionFace = 2000;
constexpr double kPerCornerOfAGain = 40;
// Bytes that a corner of a small Draco mesh takes at the least.
constexpr double kLeastCornerBytes = 0.5;

double ExpectedSweeps(const SolveOptions& solve) {
  double usual = solve.max_sweeps;
  if (solve.tolerance > 0) {
    switch (solve.method) {
      case SolveMethod::kAutomatic:
      case SolveMethod::kChebyshev:
      case SolveMethod::kGaussSeidel:
        usual = 20;
        break;
      case SolveMethod::kJacobi:
      case SolveMethod::kConjugateGradient:
        usual = 60;
        break;
      case SolveMethod::kSeries:
        usual = 200;
        break;
    }
  }
  return std::min<double>(usual, solve.max_sweeps);
}

double PerEncodedCorner(v1::MeshEncoding encoding) {
  switch (encoding) {
    case v1::MESH_ENCODING_DRACO:
      return 60;
    case v1::MESH_ENCODING_DRACO_QUANTIZED:
      return 250;
    default:
      return 5;
  }
}

double ConstraintCount(const Constraints& constraints) {
  return static_cast<double>(constraints.normals.size() + constraints.shape_handles.size() +
                             (constraints.interpolate ? constraints.interpolate->size() / 16 : 0));
}

// What blending takes: two refinements at the least, and each constraint.
double BlendNanoseconds(const JobSpec& spec, double corners) {
  const Constraints& constraints = spec.engine.constraints;
  const bool blends = spec.engine.scheme != Scheme::kDooSabin &&
                      (!constraints.normals.empty() || !constraints.surface_points.empty());
  if (!blends) return 0;
  double nanoseconds = 16 * kPerSurfaceCorner * corners +
                       kPerBlend * static_cast<double>(constraints.normals.size());
  for (const SurfaceConstraint& constraint : constraints.surface_points) {
    nanoseconds +=
        kPerSurfaceConstraint + kPerRegionFace * static_cast<double>(constraint.region.size());
  }
  return nanoseconds;
}

}  // namespace

std::uint64_t EstimateMilliseconds(const JobSpec& spec) {
  double corners = static_cast<double>(spec.mesh.corner_count());
  if (corners == 0) corners = static_cast<double>(spec.mesh.byte_count()) / kLeastCornerBytes;
  double nanoseconds =
      corners * (kPerCorner + kPerCornerOfASweep * ExpectedSweeps(spec.engine.solve));
  if (spec.repair) nanoseconds += corners * kPerCornerOfRepair;
  if (spec.send_control_mesh) {
    nanoseconds += corners * PerEncodedCorner(spec.control_mesh.encoding);
  }
  if (spec.send_surface) {
    const bool chosen = spec.engine.chord_tolerance.has_value();
    const int level = static_cast<int>(chosen ? spec.engine.finest : spec.engine.level);
    nanoseconds += std::ldexp(corners, 2 * level) *
                   (kPerSurfaceCorner + PerEncodedCorner(spec.tiles.encoding));
  }
  nanoseconds += kPerConstraint * ConstraintCount(spec.engine.constraints);
  nanoseconds += BlendNanoseconds(spec, corners);
  if (spec.filter.has_value()) {
    nanoseconds += corners * kPerCornerOfAGain * static_cast<double>(spec.filter->gains.size());
  }
  constexpr double kMost = 1e15;
  return static_cast<std::uint64_t>(std::clamp(nanoseconds / 1e6, 1.0, kMost));
}

}  // namespace limn
