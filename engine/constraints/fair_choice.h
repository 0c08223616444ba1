// SPDX-License-Identifier: MIT
// Chooses among several shapes of a surface vertex by vertex, so that a cure is taken where it
// helps and left where it does harm. Used by engine/constraints/fair.h.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/fair_faces.h"

namespace limn {

// Which cures were applied.
struct FairCures {
  bool shape_handles = false;
  bool smoothing = false;
};

// A shape that has been measured.
struct MeasuredCorners {
  // M^1.
  absl::Span<const Vec3> corners;
  // As BendingEnergyMeter::patches() says.
  absl::Span<const double> patches;
  FairCures cures;
};

// Every type-V face is that of the shape, of those looked at, under which the faces of the mesh
// around its vertex bend least; the first of equals. Of its neighbours' choices it does not know:
// so the whole has to be measured. All functions: errors CANCELLED, DEADLINE_EXCEEDED; cost a pass
// over corners; same bits for any number of threads.
class FairChoice {
 public:
  // faces: must outlive this.
  explicit FairChoice(const FairFaces& faces) : faces_(faces) {}

  // Looks at a shape.
  [[nodiscard]] absl::Status Consider(const Context& context, const MeasuredCorners& shape);
  // The choice itself has been measured: goes on from what it is.
  [[nodiscard]] absl::Status Renew(const Context& context, absl::Span<const double> patches);

  // The choice, and the cures that are anywhere in it.
  const Buffer<Vec3>& corners() const { return corners_; }
  FairCures cures() const;

 private:
  absl::Status Measure(const Context& context, absl::Span<const double> patches);
  double EnergyAround(std::size_t v) const;

  const FairFaces& faces_;
  Buffer<Vec3> corners_;
  // By face of the mesh, of the shape that is looked at.
  Buffer<double> face_;
  // By vertex: the least energy around, and the cures.
  Buffer<double> least_;
  Buffer<FairCures> cures_;
};

}  // namespace limn
