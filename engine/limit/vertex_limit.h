// SPDX-License-Identifier: MIT
// Limit points, tangents and normals of Catmull-Clark and Loop surfaces at the vertices of T^k.
// Masks, their sources and their derivation: engine/limit/limit_masks.h.
//
// Rules. A vertex counts as smooth, dart, crease or corner by what is sharp around it for ever:
// what wears off is refined away first, around that vertex alone. Holes have limits like other
// faces.
//
// Tangents u and v. After j more refinements the end of edge i of the vertex is at
//   smooth: S + lambda^j (cos(2 pi i / n) u + sin(2 pi i / n) v) + what shrinks faster,
// edge 0 being that of vertex_half_edge(v). At regular vertices (valence 4, or 6) u and v are the
// derivatives by parameters in which edges have length 1: v is across u, not along the next edge.
//   dart: u along the sharp edge, in its direction; v across.
//   crease, boundary: u is the derivative of the curve, towards the first edge of the fan (at
//     boundaries) or the first sharp edge from vertex_half_edge(v) on; v points to its left, into
//     the faces. Where there is one face, v is the curve's second derivative (the way to the quad's
//     fourth vertex where the curve has no bend to speak of).
//   corner: the derivatives of the first sharp curve and of the next one counter-clockwise.
//   corner inside the mesh without sharp edges: as smooth.
// For meshes from Build, Catmull-Clark's rings are those of T^1, so that faces may have any arity,
// and the tangents, those of T^1, are shorter by a factor of lambda; likewise by one for each
// refinement until what is sharp has worn off.
//
// Normals are unit vectors, the direction of u x v: outward for counter-clockwise faces. Where
// surfaces meet at sharp edges, they are the mean of the surfaces' normals there; (0, 0, 0) where
// tangents span no plane, or where the normals cancel. Plain rules do not give a tangent plane
// everywhere, whatever the mask; at these vertices the answers are
//   - boundary or crease, 5 quads or 7 triangles or more to one side: the plane of the curve
//     and the direction in which the faces approach, to which normals tend along the curve;
//   - corners between two sharp edges, of 2 quads or 3 triangles or more, and of 2 triangles where
//     the curves form a straight line within 0.05 rad: the mean of the planes at both ends, each
//     that of the curve and the direction of the faces. (At 2 quads or 3 triangles all planes tend
//     to that of the two curves, but like 1 / k in the number of refinements: what is given is what
//     T^k sees. Fewer faces: the plane of the two curves; at one quad whose curves form a line
//     within 1e-3 rad, that of the line and the quad's fourth vertex.)
//   - corners without sharp edges (cusps) and vertices of valence 2: the mean of the normals of the
//     faces around, weighted by area, to which u x v belongs.
//
// Differences to OpenSubdiv 3.5 (PrimvarRefiner::Limit). Points: around what wears off (it takes
// what is sharp now to be sharp for ever), darts (it takes the smooth mask, which does not hold
// there), smooth vertices of valence 2 (it takes the vertex itself), meshes with other faces than
// quads. Tangents, beyond scale and choice of the first edge: darts;
// boundaries and creases of 3 quads or 4 triangles or more (its masks belong to other rules);
// boundary vertices of one quad whose curve is straight (its two tangents are parallel there);
// corners, where it takes the first two edges rather than the two sharp ones; normals at creases
// inside the mesh, where it answers for one side. Everything else is equal to rounding. Bfr, which
// approximates around extraordinary vertices, has the same points and tends to these normals: it is
// 3e-3 off with its default approximation level of 2, 7e-4 with 4 and 3e-6 with 10.
#pragma once

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/limit/ring_limit.h"
#include "engine/scheme/sharpness.h"

namespace limn {

// Where to write: for the vertices 0 .. points.size() - 1, not more than there are. tangents and
// normals are of the same size, or empty when not asked for.
struct VertexLimits {
  absl::Span<Vec3> points;
  absl::Span<Tangents> tangents;
  absl::Span<Vec3> normals;
};

// level: T^k and its sharpness; of any arities for a mesh from Build. points: of T^k, apart from
// the limits. Errors: INTERNAL when a size does not fit; CANCELLED, DEADLINE_EXCEEDED. Cost: one
// pass over half-edges; for meshes from Build also a point per face. Points do not depend on what
// else is asked for. Same bits for any number of threads. Thread-safe.
[[nodiscard]] absl::Status CatmullClarkLimits(const Context& context, const SurfaceLevel& level,
                                              absl::Span<const Vec3> points,
                                              const VertexLimits& limits);

// level: T^k of triangles, from Build or refined. Else as above; errors: also as RequireTriangles.
[[nodiscard]] absl::Status LoopLimits(const Context& context, const SurfaceLevel& level,
                                      absl::Span<const Vec3> points, const VertexLimits& limits);

}  // namespace limn
