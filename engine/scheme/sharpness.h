// SPDX-License-Identifier: MIT
// Semi-sharp creases and corners, boundaries and holes of Catmull-Clark and Loop surfaces, with the
// meaning that OpenSubdiv and USD give them: what a user asks for, and the sharpness of the edges
// and vertices of each level.
// Sources: DeRose, Kass and Truong, "Subdivision Surfaces in Character Animation", 1998; Hoppe et
// al., "Piecewise smooth surface reconstruction", 1994 (dart, crease, corner); OpenSubdiv's user
// guide, "Semi-sharp creases" and "Boundary interpolation" (uniform creasing).
//
// An edge or vertex of sharpness s is infinitely sharp for s refinements and smooth from then on;
// a fraction blends the two rules of one refinement. kSharpForever and more never wears off.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

inline constexpr float kSharpForever = 10;

// What becomes of an open mesh's boundary. Names and meaning are OpenSubdiv's
// VtxBoundaryInterpolation. Under all of them boundary edges are infinitely sharp, so that the
// boundary is a cubic B-spline curve that depends on boundary vertices only.
enum class BoundaryRule {
  // Faces at the boundary only support the surface, as holes do. Those that stay: where every
  // boundary edge at each boundary vertex of the face was given a sharpness of kSharpForever.
  kNone,
  // The surface extends to the boundary curve, which is smooth everywhere.
  kEdgeOnly,
  // Besides, boundary vertices of one face are infinitely sharp: the surface's corners.
  kEdgeAndCorner,
};

// What is asked for; names and meaning are those of USD's UsdGeomMesh.
struct CreaseInput {
  // Creases, one after the other: the vertices along each.
  absl::Span<const Index> crease_indices;
  // Vertices of each crease, 2 or more; they add up to crease_indices.
  absl::Span<const Index> crease_lengths;
  // One for each crease, or one for each of its edges (lengths less 1, added up). Sharpnesses are 0
  // or more; infinite is allowed. An edge named again takes the last value, as in OpenSubdiv.
  absl::Span<const float> crease_sharpnesses;
  // Vertices, and the sharpness of each.
  absl::Span<const Index> corner_indices;
  absl::Span<const float> corner_sharpnesses;
  // Faces that support the surface but are not part of it.
  absl::Span<const Index> hole_indices;
  BoundaryRule boundary = BoundaryRule::kEdgeAndCorner;
};

// Sharpness of one level T^k. Default: nothing is sharp but the boundary. Plain data.
struct Sharpness {
  BoundaryRule boundary = BoundaryRule::kEdgeAndCorner;
  // Of each edge and of each vertex, with boundary edges and (by the rule) corners at
  // kSharpForever. Both empty: nothing else is sharp.
  Buffer<float> edge;
  Buffer<float> vertex;
  // 1 for holes, 0 for the other faces. Empty: no holes.
  Buffer<std::uint8_t> hole;
  // The largest sharpness that wears off: after its ceiling of refinements every rule is settled.
  float transient = 0;
  // Whether something inside the boundary is sharp forever.
  bool lasting = false;

  bool creased() const { return !edge.empty(); }
};

// A level of a Catmull-Clark or Loop surface beside its points: what refinement and limits need.
struct SurfaceLevel {
  // T^k.
  const HalfEdgeMesh& mesh;
  // Of T^k.
  const Sharpness& sharpness;
};

// The sharpness of T^0. mesh: from HalfEdgeMesh::Build. Errors, with the path of the entry, such as
// "crease_indices[3]", and its index: INDEX_OUT_OF_RANGE for vertices and faces that are not there,
// INVALID_OPTION for pairs of vertices that are no edge, sharpnesses that are negative or no
// numbers, lengths below 2, lists whose sizes do not fit; CANCELLED, DEADLINE_EXCEEDED. Cost: one
// pass over the input, times the smaller valence of each edge's ends, where that is large once for
// each edge; passes over edges, vertices
// and faces of the mesh as far as they are filled. Thread-safe.
[[nodiscard]] absl::StatusOr<Sharpness> MakeSharpness(const Context& context,
                                                      const HalfEdgeMesh& mesh,
                                                      const CreaseInput& input);

// The sharpness of T^(k+1). refined: the split of `mesh` into quads or triangles. Edges and
// vertices that lie on old ones have theirs, less 1; the others have none. Errors: CANCELLED,
// DEADLINE_EXCEEDED. Cost: one pass over the refined edges, vertices and faces when creased.
// Same result for any number of threads. Thread-safe.
[[nodiscard]] absl::StatusOr<Sharpness> RefineSharpness(const Context& context,
                                                        const HalfEdgeMesh& mesh,
                                                        const HalfEdgeMesh& refined,
                                                        const Sharpness& sharpness);

// Sharpness after one refinement.
inline float Worn(float sharpness) {
  return sharpness >= kSharpForever ? sharpness : std::max(0.0F, sharpness - 1);
}

// The rule of a vertex: by its own sharpness and the number of its sharp edges.
enum class VertexRule { kSmooth, kDart, kCrease, kCorner };
inline VertexRule RuleOf(float vertex_sharpness, std::size_t sharp_edges) {
  if (vertex_sharpness > 0 || sharp_edges > 2) return VertexRule::kCorner;
  if (sharp_edges == 2) return VertexRule::kCrease;
  return sharp_edges == 1 ? VertexRule::kDart : VertexRule::kSmooth;
}
// Darts refine as smooth vertices.
inline bool IsSmoothRule(VertexRule rule) {
  return rule == VertexRule::kSmooth || rule == VertexRule::kDart;
}

// The refined point of one edge: its midpoint while sharp, else the scheme's smooth point.
inline Vec3 BlendEdge(float sharpness, const Vec3& middle, const Vec3& smooth) {
  if (sharpness >= 1) return middle;
  const double weight = sharpness;
  return weight * middle + (1 - weight) * smooth;
}

// The refined point of one vertex. Fill it with all edges around the vertex, then ask.
class VertexBlend {
 public:
  VertexBlend(const Vec3& point, float sharpness) : point_(point), sharpness_(sharpness) {
    if (sharpness > 0 && Worn(sharpness) == 0) AddTransition(sharpness);
  }

  // An edge to the vertex at `end`.
  void Add(float sharpness, const Vec3& end) {
    if (!(sharpness > 0)) return;
    ++now_.edges;
    now_.ends += end;
    if (Worn(sharpness) > 0) {
      ++next_.edges;
      next_.ends += end;
    } else {
      AddTransition(sharpness);
    }
  }

  // Whether the smooth point takes part.
  bool needs_smooth() const { return IsSmoothRule(rule()) || IsSmoothRule(next_rule()); }
  // The point, given the scheme's smooth one (any, when it is not needed). Where the rule changes
  // with this refinement, the old rule counts by the mean of the sharpnesses that vanish.
  Vec3 Point(const Vec3& smooth) const {
    if (IsSmoothRule(rule())) return smooth;
    const Vec3 now = Apply(rule(), now_, smooth);
    if (rule() == next_rule()) return now;
    const double weight = std::min(1.0, vanishing_ / std::max(1, vanishing_count_));
    return weight * now + (1 - weight) * Apply(next_rule(), next_, smooth);
  }

 private:
  // Sharp edges of a step.
  struct Sharp {
    std::size_t edges = 0;
    Vec3 ends = {0, 0, 0};
  };

  VertexRule rule() const { return RuleOf(sharpness_, now_.edges); }
  VertexRule next_rule() const { return RuleOf(Worn(sharpness_), next_.edges); }
  void AddTransition(float sharpness) {
    vanishing_ += sharpness;
    ++vanishing_count_;
  }
  Vec3 Apply(VertexRule rule, const Sharp& sharp, const Vec3& smooth) const {
    if (rule == VertexRule::kCorner) return point_;
    // The cubic B-spline curve.
    if (rule == VertexRule::kCrease) return 0.75 * point_ + 0.125 * sharp.ends;
    return smooth;
  }

  Vec3 point_;
  float sharpness_;
  Sharp now_;
  Sharp next_;
  double vanishing_ = 0;
  int vanishing_count_ = 0;
};

}  // namespace limn
