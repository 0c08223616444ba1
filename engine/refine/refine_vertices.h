// SPDX-License-Identifier: MIT
// What Catmull-Clark and Loop refinement have in common: the pass over the old vertices, with the
// rules of boundaries and creases. A scheme contributes its smooth point.
#pragma once

#include <cstddef>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/base/vec3.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/scheme/sharpness.h"

namespace limn {

// Ok when there is one point for each vertex, and room for those of [vertices | edges | others].
// Error: INTERNAL.
[[nodiscard]] inline absl::Status CheckRefinedSizes(const SurfaceLevel& level, std::size_t points,
                                                    std::size_t refined, std::size_t others) {
  const HalfEdgeMesh& mesh = level.mesh;
  if (points == mesh.vertex_count() && refined == points + mesh.edge_count() + others) {
    return absl::OkStatus();
  }
  return MakeError(absl::StrCat(points, " points of ", mesh.vertex_count(),
                                " vertices cannot be refined to ", refined),
                   {.reason = Reason::kInternal});
}

// Refined points of the vertices of T^k.
// Star: collects what is around a vertex; a copy of `empty` is used for each vertex.
//   void Add(Index h): a half-edge that leaves the vertex;
//   Vec3 Point(const Vec3& own) const: the smooth point, asked for inside the mesh only.
template <class Walk, class Star>
class VertexRefiner {
 public:
  VertexRefiner(const SurfaceLevel& level, const Vec3* in, const Star& empty)
      : mesh_(level.mesh), sharpness_(level.sharpness), walk_(level.mesh), in_(in), empty_(empty) {}

  absl::Status Run(const Context& context, Vec3* out) const {
    if (sharpness_.creased()) {
      return ForEach(context, [this, out](std::size_t v) { out[v] = CreasedPoint(v); });
    }
    // Meshes from Build have fans, in the order in which twins lead around: read off them, no step
    // has to wait for the one before.
    if (mesh_.arity() == 0) {
      return ForEach(context, [this, out](std::size_t v) { out[v] = PointByFan(v); });
    }
    return ForEach(context, [this, out](std::size_t v) { out[v] = PointByTwins(v); });
  }

 private:
  static constexpr std::size_t kGrain = 512;

  template <class Body>
  absl::Status ForEach(const Context& context, const Body& body) const {
    return ParallelFor(context, mesh_.vertex_count(), kGrain,
                       [&](std::size_t begin, std::size_t end) {
                         for (std::size_t v = begin; v < end; ++v) body(v);
                       });
  }

  Vec3 PointByFan(std::size_t v) const {
    Star star = empty_;
    const Index* const fan = mesh_.fan().data();
    const Index end = mesh_.fan_begin()[v + 1];
    for (Index i = mesh_.fan_begin()[v]; i < end; ++i) star.Add(fan[i]);
    if (mesh_.twin()[mesh_.vertex_half_edge()[v]] != kNoIndex) return star.Point(in_[v]);
    return BoundaryPoint(v, walk_.Prev(fan[end - 1]));
  }

  Vec3 PointByTwins(std::size_t v) const {
    Star star = empty_;
    const Index entering =
        VisitFan(walk_, mesh_.twin(), mesh_.vertex_half_edge()[v], [&](Index h) { star.Add(h); });
    return entering == kNoIndex ? star.Point(in_[v]) : BoundaryPoint(v, entering);
  }

  // entering: the half-edge that enters the vertex along the boundary.
  Vec3 BoundaryPoint(std::size_t v, Index entering) const {
    const Index start = mesh_.vertex_half_edge()[v];
    const bool one_face = entering == walk_.Prev(start);
    if (one_face && sharpness_.boundary == BoundaryRule::kEdgeAndCorner) return in_[v];
    return 0.75 * in_[v] + 0.125 * (End(start) + in_[mesh_.vertex()[entering]]);
  }

  Vec3 CreasedPoint(std::size_t v) const {
    Star star = empty_;
    VertexBlend blend(in_[v], sharpness_.vertex[v]);
    const Index entering = VisitFan(walk_, mesh_.twin(), mesh_.vertex_half_edge()[v], [&](Index h) {
      star.Add(h);
      blend.Add(sharpness_.edge[mesh_.edge()[h]], End(h));
    });
    if (entering != kNoIndex) {
      blend.Add(sharpness_.edge[mesh_.edge()[entering]], in_[mesh_.vertex()[entering]]);
    }
    // Boundary vertices have two sharp edges forever.
    return blend.Point(blend.needs_smooth() ? star.Point(in_[v]) : in_[v]);
  }

  const Vec3& End(Index h) const { return in_[mesh_.vertex()[walk_.Next(h)]]; }

  const HalfEdgeMesh& mesh_;
  const Sharpness& sharpness_;
  const Walk walk_;
  const Vec3* in_;
  const Star empty_;
};

}  // namespace limn
