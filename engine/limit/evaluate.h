// SPDX-License-Identifier: MIT
// Exact evaluation of a Doo-Sabin limit surface: position, first derivatives and unit normal at any
// parameter. Sources: Doo and Sabin 1978; Stam 1998; engine/limit/ring_patch.h has the method.
//
// Each corner of a face of T^0 owns a patch, the square (u, v) in [0, 1]^2: u runs along the
// half-edge that leaves the corner, from its vertex to the middle of its edge; v likewise along the
// half-edge that enters it; (1, 1) is the middle of the face. These are the quads of T^1
// (engine/limit/tessellation.h): at u and v in multiples of 2^-k lie the vertices of T^(k+1).
//
// The surface is twice differentiable inside the pieces of a patch and once across them and across
// patches, where u and v change roles and signs. Extraordinary points are the vertices and middles
// whose face in M^1 has not four sides: vertices not of four faces (inside) or of three and more
// (on a boundary), faces not of four sides. There the tangent plane is continuous, but derivatives
// by u and v have a limit for each direction: those along the sides of the patch are returned.
// Vertices of two faces (inside) have no tangent plane; around them derivatives grow beyond all
// bounds, except along the sides of the patch, where they go to zero.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/limit/large_faces.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

// A point of the parameter domain. Both coordinates in [0, 1], denormal numbers too.
struct SurfaceParameter {
  Index face = 0;
  // Of the face, 0 to arity - 1.
  Index corner = 0;
  double u = 0;
  double v = 0;
};

// Where to write: each span has one element per parameter, or none when it is not asked for.
struct SurfaceSamples {
  // In the model's frame.
  absl::Span<Vec3> points = {};
  // First derivatives.
  absl::Span<Vec3> du = {};
  absl::Span<Vec3> dv = {};
  // Unit length, outward for counter-clockwise faces; (0, 0, 0) where the derivatives span no
  // plane.
  absl::Span<Vec3> normals = {};
};

class SurfaceEvaluator {
 public:
  // surface must outlive the evaluator. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: as
  // LargeFaces::Find.
  [[nodiscard]] static absl::StatusOr<SurfaceEvaluator> Create(const Context& context,
                                                               const DooSabinSurface& surface);

  // Evaluates at parameters[i] for all i. Along a boundary the points are those of the boundary
  // curve, so that two surfaces that share one share them to the bit; at extraordinary points they
  // and the normals are those of DooSabinLimit to the bit.
  //
  // first: number of parameters[0] among all parameters, for messages. Errors: INDEX_OUT_OF_RANGE
  // and INVALID_OPTION (u or v is outside [0, 1] or not a number) with the field, such as
  // "parameters[17].corner", of the first that is wrong; CANCELLED and DEADLINE_EXCEEDED within
  // one chunk of work. After an error the spans hold anything.
  //
  // Cost: constant per parameter, however near an extraordinary point and whatever the sides of its
  // face. Same bits for any number of threads. Thread-safe; runs in the caller's arena.
  [[nodiscard]] absl::Status Evaluate(const Context& context,
                                      absl::Span<const SurfaceParameter> parameters,
                                      const SurfaceSamples& samples, std::uint64_t first = 0) const;

 private:
  SurfaceEvaluator(const DooSabinSurface& surface, LargeFaces large_faces);

  const DooSabinSurface* surface_;
  LargeFaces large_faces_;
};

// Both at once.
[[nodiscard]] absl::Status EvaluateSurface(const Context& context, const DooSabinSurface& surface,
                                           absl::Span<const SurfaceParameter> parameters,
                                           const SurfaceSamples& samples);

}  // namespace limn
