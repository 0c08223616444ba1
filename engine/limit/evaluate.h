// SPDX-License-Identifier: MIT
// Exact evaluation of a limit surface of any scheme: position, first derivatives and unit normal at
// any parameter. Sources: Doo and Sabin 1978; Stam 1998; the methods are those of
// engine/limit/ring_patch.h (Doo-Sabin) and engine/limit/primal_patch.h (Catmull-Clark, Loop).
//
// Doo-Sabin and Catmull-Clark: each corner of a face of T^0 owns a patch, the square (u, v) in
// [0, 1]^2: u runs along the half-edge that leaves the corner, from its vertex to the middle of its
// edge; v likewise along the half-edge that enters it; (1, 1) is the middle of the face. These are
// the quads of T^1 (engine/limit/tessellation.h): at u and v in multiples of 2^-k lie the vertices
// of T^(k+1).
// Loop: each triangle of T^0 is a patch, 0 <= u, v and u + v <= 1, and its corner says which vertex
// is the origin: u runs along the whole edge that leaves the corner, v along the one that enters
// it. At u and v in multiples of 2^-k lie the vertices of T^k. The sum counts as rounded, so that
// 0.1 and 0.9 are in the triangle.
//
// A Doo-Sabin surface is twice differentiable inside the pieces of a patch and once across them and
// across patches, where u and v change roles and signs. Extraordinary points are the vertices and
// middles whose face in M^1 has not four sides: vertices not of four faces (inside) or of three and
// more (on a boundary), faces not of four sides. There the tangent plane is continuous, but
// derivatives by u and v have a limit for each direction: those along the sides of the patch are
// returned. Vertices of two faces (inside) have no tangent plane; around them derivatives grow
// beyond all bounds, except along the sides of the patch, where they go to zero.
//
// Catmull-Clark and Loop surfaces are twice differentiable but at extraordinary points and at what
// is sharp for ever. On sharp edges the answer is that of the patch's own side. Extraordinary
// points are the vertices not of four quads of T^1 or of six triangles, and those on boundaries and
// creases not of two or three to the patch's side. There derivatives by u and v grow beyond all
// bounds or vanish: what is returned are tangents along the sides of the patch; see RingCorner in
// engine/limit/ring_limit.h. Normals are continuous where engine/limit/vertex_limit.h says so.
// Where constraints are met by blending (engine/constraints/blend.h) the net that evaluation starts
// from is finer: all answers differ by rounding, and tangents at extraordinary points by a factor.
#pragma once

#include <cstdint>
#include <memory>
#include <variant>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/limit/primal_surface.h"
#include "engine/limit/surface_parameter.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

class PatchSource;

// A limit surface of any scheme.
using LimitSurface = std::variant<DooSabinSurface, PrimalSurface>;

// Where to write: each span has one element per parameter, or none when it is not asked for.
struct SurfaceSamples {
  // In the model's frame.
  absl::Span<Vec3> points = {};
  // First derivatives.
  absl::Span<Vec3> du = {};
  absl::Span<Vec3> dv = {};
  // Unit length, outward for counter-clockwise faces; (0, 0, 0) where the derivatives span no
  // plane, such as where a plane region of feature values runs straight through the corner of its
  // face: the tessellation has the region's normal there.
  absl::Span<Vec3> normals = {};
};

class SurfaceEvaluator {
 public:
  // surface must outlive the evaluator. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: Doo-Sabin as
  // LargeFaces::Find, else none.
  [[nodiscard]] static absl::StatusOr<SurfaceEvaluator> Create(const Context& context,
                                                               const DooSabinSurface& surface);
  [[nodiscard]] static absl::StatusOr<SurfaceEvaluator> Create(const Context& context,
                                                               const PrimalSurface& surface);
  [[nodiscard]] static absl::StatusOr<SurfaceEvaluator> Create(const Context& context,
                                                               const LimitSurface& surface);
  SurfaceEvaluator(SurfaceEvaluator&&) noexcept;
  SurfaceEvaluator& operator=(SurfaceEvaluator&&) noexcept;
  ~SurfaceEvaluator();

  // Evaluates at parameters[i] for all i. Doo-Sabin: along a boundary the points are those of the
  // boundary curve, so that two surfaces that share one share them to the bit; at extraordinary
  // points they and the normals are those of DooSabinLimit to the bit. Catmull-Clark and Loop: both
  // within rounding.
  //
  // first: number of parameters[0] among all parameters, for messages. Errors: INDEX_OUT_OF_RANGE
  // and INVALID_OPTION (u or v is outside the patch or not a number) with the field, such as
  // "parameters[17].corner", of the first that is wrong; CANCELLED and DEADLINE_EXCEEDED within
  // one chunk of work. After an error the spans hold anything.
  //
  // Cost per parameter: Doo-Sabin constant, however near an extraordinary point and whatever the
  // sides of its face. Catmull-Clark and Loop: constant in regular patches; else a refinement of
  // the patch for each halving of the distance to an extraordinary point, each linear in the
  // valence, and for as long as something at the patch wears off. Same bits for any number of
  // threads. Thread-safe; runs in the caller's arena.
  [[nodiscard]] absl::Status Evaluate(const Context& context,
                                      absl::Span<const SurfaceParameter> parameters,
                                      const SurfaceSamples& samples, std::uint64_t first = 0) const;

 private:
  explicit SurfaceEvaluator(std::unique_ptr<const PatchSource> source);

  std::unique_ptr<const PatchSource> source_;
};

// Both at once, of any of the three.
template <class Surface>
[[nodiscard]] absl::Status EvaluateSurface(const Context& context, const Surface& surface,
                                           absl::Span<const SurfaceParameter> parameters,
                                           const SurfaceSamples& samples) {
  const absl::StatusOr<SurfaceEvaluator> evaluator = SurfaceEvaluator::Create(context, surface);
  if (!evaluator.ok()) return evaluator.status();
  return evaluator->Evaluate(context, parameters, samples);
}

}  // namespace limn
