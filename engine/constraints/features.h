// SPDX-License-Identifier: MIT
// Doo-Sabin surfaces from feature values: a first refinement of the given mesh itself, without a
// solve, after which everything is as for any other surface. Source: Xu and Kondo, "Introducing
// feature values for effective specification of polyhedral networks", section 3.2.
//
// Surface faces get the images of engine/constraints/feature_face.h.
//
// Plane faces (section 3.2.2; values of edges and vertices in them count for nothing). The surface
// around a plane face is an open one that ends at its edges, so the mesh is cut along them
// (engine/constraints/feature_cut.h) and both sides share a boundary curve
// (engine/refine/boundary_curve.h). At an edge between a plane and a surface face its points are
// the feet of the perpendiculars from the surface face's images of the edge's ends: the paper's V_s
// and V_e, in which the images are mirrored so that the curve is met. The plane region is a
// Doo-Sabin surface of one face inside the curve: planar, and bounded by the quadratic B-spline
// whose control polygon are the feet. What the paper leaves open:
//   Feet outside of their edge are taken to its nearer end; feet in the wrong order, both to their
//   middle; those on an edge without length are its ends.
//   A vertex of two or more plane faces, of a plane face and the mesh's boundary, or of a plane
//   face and to be interpolated, is a corner: the surface passes through it, and the curves end
//   there. With one surface face between two plane ones that is the paper's 4 C - p_1 - p_2 - p_3,
//   with more of them the same for any number (see BoundaryCurve).
//   A vertex of one plane face and m surface faces gets the 2m-sided type-V face of a boundary
//   vertex and not the paper's m + 2 sides: these are the same for m = 2, and for m = 3 and more
//   the paper's would not keep the B-spline.
//   An edge between two plane faces, whose ends are corners, is met as a straight line. Its curve
//   points are (3 V + V') / 4 and not its ends, which give the same line with derivatives that
//   vanish.
//   The images of a plane face only say how the flat region is parametrised: the mean of the
//   curve's point at the vertex and of these points' mean. Faces have to be convex: in others the
//   region is planar and has its boundary, but it may fold, so that its tessellation covers parts
//   of the plane more than once or beyond the boundary.
//   Plane faces that are not planar are made so first, by FlattenPlaneFaces; feet, and the images
//   of the surface faces around, follow from the moved vertices.
//   A mesh of plane faces only: every vertex is a corner, and the surface is the polyhedron.
//   Along cuts the surface has two tangent planes, and at most one at the ends of a plane region's
//   run along a vertex of one plane face: derivatives by the parameters of that corner are
//   parallel.
//
// Open meshes: along the boundary the curve is that of the given points as control points, whatever
// the values of edges and vertices. Only plane faces change it: at their vertices, which are
// corners, it ends and begins anew, and vertices that FlattenPlaneFaces moves move it. So meshes
// that share a boundary share the curve where the same vertices of it are in plane faces, all of
// them planar.
//
// Interpolated vertices (Constraints::interpolate; by default none): afterwards their type-V faces
// are moved as everywhere (engine/constraints/perturb.h), with prescribed normals and shape
// handles. At vertices of plane faces there are no normals and handles, and those that
// FlattenPlaneFaces had to move cannot be interpolated.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/constraints.h"
#include "engine/constraints/feature_values.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

struct FeatureTask {
  // One point per vertex, in the model's frame.
  absl::Span<const Vec3> points;
  // With features; as ValidateConstraints and ValidateDooSabinNormals accept them for the mesh.
  const Constraints& constraints;
  // The surface's corners are relative to this.
  Vec3 origin = {0, 0, 0};
};

// The surface of a mesh whose feature values and points may change again and again, in about half
// of the time that it takes with its connectivity (FeatureValues and FeatureValuesAfresh of
// tests/benchmarks/engine_benchmark.cc). What is made of surface().mesh alone, such as the fans and
// the connectivity that refinement needs, stays good as long as cuts() is the same. Not
// thread-safe.
class FeatureSurface {
 public:
  // mesh: from HalfEdgeMesh::Build. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: a pass over its
  // half-edges.
  [[nodiscard]] static absl::StatusOr<FeatureSurface> Create(const Context& context,
                                                             HalfEdgeMesh mesh);

  // Makes the surface of these values and points. Connectivity is kept, with its memory and that of
  // the surface; only when other faces are plane than before it is cut anew. After an error the
  // surface must be made again.
  //
  // Errors: those of MakeFeatureTable and FlattenPlaneFaces; INVALID_OPTION for normals and handles
  // at vertices of plane faces, and for interpolated vertices that are moved; CANCELLED,
  // DEADLINE_EXCEEDED. Cost: a few passes over the corners. Same bits for any number of threads,
  // and whatever was made before.
  [[nodiscard]] absl::Status Make(const Context& context, const FeatureTask& task);

  // T^0 as given.
  const HalfEdgeMesh& given() const { return given_.has_value() ? *given_ : surface_.mesh; }
  // What Make made: its mesh is T^0, cut along plane faces.
  const DooSabinSurface& surface() const { return surface_; }
  bool cut() const { return given_.has_value(); }
  // Whether a face was a plane one in the last Make.
  bool IsPlane(Index face) const { return !plane_.empty() && plane_[face] != 0; }
  // Times that the mesh was cut or put together again.
  std::uint32_t cuts() const { return cuts_; }

  // Moves the parts out, after the last Make.
  DooSabinSurface TakeSurface() && { return std::move(surface_); }
  // T^0 as given, if it was cut.
  std::optional<HalfEdgeMesh> TakeGiven() && { return std::move(given_); }

 private:
  class Maker;
  explicit FeatureSurface(HalfEdgeMesh mesh)
      : surface_{.mesh = std::move(mesh), .corners = {}, .boundary = {}} {}

  absl::Status FollowPlanes(const Context& context, const FeatureTable& table);

  // Only when it is cut.
  std::optional<HalfEdgeMesh> given_;
  DooSabinSurface surface_;
  // What it is cut along.
  Buffer<std::uint8_t> plane_;
  std::uint32_t cuts_ = 0;
};

}  // namespace limn
