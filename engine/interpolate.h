// SPDX-License-Identifier: MIT
// The whole job: from a given mesh to the control mesh and the tessellated limit surface that
// passes through the given vertices. One pipeline for every scheme:
//   build -> solve -> first refinement -> constraints -> refine -> limit.
// With feature values (engine/constraints/features.h) there is no solve: they are the first
// refinement of the given mesh. Source: Zheng and Cai, "Making Doo-Sabin surface interpolation
// always work over irregular meshes", The Visual Computer 2005, section 3.4.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/blend.h"
#include "engine/constraints/constraints.h"
#include "engine/constraints/fair.h"
#include "engine/limit/evaluate.h"
#include "engine/limit/tessellation.h"
#include "engine/mesh/polygon_mesh.h"
#include "engine/refine/doo_sabin_rule.h"
#include "engine/scheme/sharpness.h"
#include "engine/solve/solve.h"

namespace limn {

// Subdivision scheme. kLoop is for meshes of triangles.
enum class Scheme { kDooSabin, kCatmullClark, kLoop };

struct InterpolateOptions {
  Scheme scheme = Scheme::kDooSabin;
  // First refinement. By default Doo-Sabin's is the modified one, Loop's its own, Catmull-Clark's
  // its own too, but where the equations are singular or nearly so (see engine/solve/regularity.h)
  // half of the bilinear rule is blended in: such surfaces are Catmull-Clark surfaces of the once
  // refined mesh. Named, a rule is kept to.
  std::optional<FirstRule> rule;
  // Refuse with ILL_CONDITIONED rather than blend in another rule.
  bool strict = false;
  // What becomes of the boundary of Catmull-Clark and Loop surfaces; kEdgeAndCorner by default.
  std::optional<BoundaryRule> boundary;
  SolveOptions solve;
  // What the surface meets; by default all vertices are interpolated. With constraints.features
  // they win over the solve: `solve` and `strict` are not looked at, the control mesh is the given
  // one, and vertices are interpolated, exactly, only where constraints.interpolate names them. A
  // rule or `fair` beside them is refused.
  Constraints constraints;
  // Cures of overshoot where edge lengths differ; see engine/constraints/fair.h.
  bool fair = false;
  // Refinements of the input's connectivity in the tessellation, 0 to Limits::max_level.
  std::uint32_t level = 2;
  // Instead of a level: the smallest one whose distance from the limit surface is guaranteed to be
  // at most this, in model units; greater than 0. See engine/limit/chord_bound.h. Doo-Sabin only.
  std::optional<double> chord_tolerance;
  // With a chord tolerance: the finest level that may be chosen.
  std::uint32_t finest = kMaxLevel;
  // Whether to tessellate; without, only the control mesh is found.
  bool surface = true;
  // Whether to compute normals of the tessellation.
  bool normals = true;
  // Whether to keep the surface itself for exact evaluation.
  bool keep_patches = false;
};

// Wall time of a stage.
struct StageTime {
  std::string_view stage;
  double milliseconds = 0;
};

struct InterpolateResult {
  // The control mesh: these positions with the faces of the input, in the input's order.
  Buffer<Vec3> control_positions;
  SolveReport solve;
  // First refinement used, and its share of the bilinear rule: 0 unless rule is kBilinear.
  FirstRule rule = FirstRule::kModified;
  double bilinear_share = 0;
  // With a chord tolerance: what is guaranteed of the distance at surface.level.
  std::optional<double> chord_bound;
  // The limit surface; its first vertices are the limit points of the input's vertices, in order.
  // Empty without `surface`.
  Tessellation surface;
  // With `fair`, where a surface or its patches were asked for.
  std::optional<FairnessReport> fairness;
  // Where normals or points on the surface are asked for of Catmull-Clark or Loop, and a surface or
  // its patches. Within the regions that moved the surface is not that of the control mesh any
  // more, but of its second refinement with some points moved.
  std::optional<BlendReport> blend;
  // With `keep_patches`. Doo-Sabin: its mesh has the input's faces and corners; along plane faces
  // of feature values it is cut.
  std::optional<LimitSurface> patches;
  // In the order in which they ran: "build", "solve", and with a surface "first_refinement",
  // "perturb" (both Doo-Sabin's; with feature values one), "fair", "blend" and "choose_level" if
  // asked for, "refine", "limit".
  std::vector<StageTime> stages;
};

// What the options ask of their scheme that it has not: INVALID_OPTION for what belongs to another
// one, UNIMPLEMENTED for what it cannot do yet, each naming the field. Interpolate checks it too;
// here it can be asked before there is a mesh. Cost: constant. Thread-safe.
[[nodiscard]] absl::Status ValidateSchemeOptions(const InterpolateOptions& options);

// Bytes of the arrays that Interpolate holds at its peak for such a mesh and options, the input
// not counted. With a chord tolerance: when the finest level is chosen. Without boundary_edges: of
// a closed mesh. 64-bit arithmetic; saturates. Cost: constant.
[[nodiscard]] std::uint64_t EstimateBytes(std::uint64_t vertices, std::uint64_t faces,
                                          std::uint64_t corners, const InterpolateOptions& options,
                                          std::uint64_t boundary_edges = 0);

// Bytes of the tessellation that Interpolate returns for such a mesh and options; 0 without
// `surface`. Otherwise as above.
[[nodiscard]] std::uint64_t EstimateSurfaceBytes(std::uint64_t vertices, std::uint64_t faces,
                                                 std::uint64_t corners,
                                                 const InterpolateOptions& options,
                                                 std::uint64_t boundary_edges = 0);

// Interpolates vertices of an oriented 2-manifold mesh, open or closed, of any arities and number
// of components.
//
// Guarantees:
// - Doo-Sabin: the surface's points at interpolated vertices are within 1e-12 of the bounding box's
//   diagonal of the input's points, whatever the solve's tolerance, and its normals there within
//   1e-10 rad of those prescribed, wherever the images around the vertex span a plane.
//   Catmull-Clark and Loop: the points are as far off as the solve's residual says.
// - The boundary of the surface is a B-spline for each boundary loop, quadratic for Doo-Sabin,
//   cubic else, which depends on the loop's vertices only, and through corners (vertices of one
//   face) on those of the piece between two corners only. Fairing leaves it alone. Corners are met
//   and sharp, but for BoundaryRule::kEdgeOnly. Doo-Sabin: two meshes that share the points along a
//   piece, in either direction, and its vertices' constraints, share the points of the curve to the
//   last bit. (So they do for Catmull-Clark and Loop where the middle of both boxes is within 64
//   diagonals of the origin: jobs run on points around their own middle otherwise.)
// - The result has the same bits for any number of threads.
//
// Errors: as HalfEdgeMesh::Build and ValidateConstraints; INVALID_OPTION for an option out of
// range; LIMIT_EXCEEDED when sizes are above the context's limits (before anything is allocated);
// OUT_OF_MEMORY; CANCELLED and DEADLINE_EXCEEDED within one chunk of work; ILL_CONDITIONED, see
// `strict`; UNIMPLEMENTED for what a scheme cannot do yet.
//
// Cost: linear in corners x 4^level. Thread-safe; runs in the caller's arena (see ThreadArena).
[[nodiscard]] absl::StatusOr<InterpolateResult> Interpolate(const Context& context,
                                                            const PolygonMesh& mesh,
                                                            const InterpolateOptions& options = {});

}  // namespace limn
