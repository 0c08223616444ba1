// SPDX-License-Identifier: MIT
#include "engine/refine/loop_refine.h"

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/triangle_split.h"
#include "engine/refine/harmonics.h"
#include "engine/refine/refine_vertices.h"

namespace limn {
namespace {

constexpr std::size_t kGrain = 512;

// The neighbours of a vertex, for its smooth point.
class Star {
 public:
  Star(const HalfEdgeMesh& mesh, const Vec3* points)
      : vertex_(mesh.vertex().data()), points_(points) {}

  void Add(Index h) {
    ends_ += points_[vertex_[TriangleWalk::Next(h)]];
    ++n_;
  }
  Vec3 Point(const Vec3& own) const {
    const double weight = n_ == 6 ? 0.375 : LoopNeighbourWeight(n_);
    return (1 - weight) * own + (weight / static_cast<double>(n_)) * ends_;
  }

 private:
  const Index* vertex_;
  const Vec3* points_;
  Vec3 ends_ = {0, 0, 0};
  std::size_t n_ = 0;
};

absl::Status RefineEdges(const Context& context, const SurfaceLevel& level, const Vec3* in,
                         Vec3* out) {
  const HalfEdgeMesh& mesh = level.mesh;
  const Index* const vertex = mesh.vertex().data();
  const bool creased = level.sharpness.creased();
  return ParallelFor(context, mesh.edge_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const Index h = mesh.edge_half_edge()[e];
      const Index t = mesh.twin()[h];
      const Vec3 ends = in[vertex[h]] + in[vertex[TriangleWalk::Next(h)]];
      const Vec3 middle = 0.5 * ends;
      if (t == kNoIndex) {
        out[e] = middle;
        continue;
      }
      const Vec3 across = in[vertex[TriangleWalk::Prev(h)]] + in[vertex[TriangleWalk::Prev(t)]];
      const Vec3 smooth = 0.375 * ends + 0.125 * across;
      out[e] = creased ? BlendEdge(level.sharpness.edge[e], middle, smooth) : smooth;
    }
  });
}

}  // namespace

double LoopNeighbourWeight(std::size_t n) {
  const double c = 0.375 + 0.25 * AngleOf(1, n).cos;
  return 0.625 - c * c;
}

absl::Status RefineLoop(const Context& context, const SurfaceLevel& level,
                        absl::Span<const Vec3> points, absl::Span<Vec3> refined) {
  const HalfEdgeMesh& mesh = level.mesh;
  LIMN_RETURN_IF_ERROR(RequireTriangles(mesh));
  LIMN_RETURN_IF_ERROR(CheckRefinedSizes(level, points.size(), refined.size(), 0));
  LIMN_RETURN_IF_ERROR(
      RefineEdges(context, level, points.data(), refined.data() + mesh.vertex_count()));
  const Star star(mesh, points.data());
  return VertexRefiner<TriangleWalk, Star>(level, points.data(), star).Run(context, refined.data());
}

}  // namespace limn
