// SPDX-License-Identifier: MIT
#include "engine/refine/catmull_clark_refine.h"

#include <cstddef>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/refine_vertices.h"

namespace limn {
namespace {

constexpr std::size_t kGrain = 512;

Vec3 CentroidOf(const HalfEdgeMesh& mesh, const Vec3* in, Index begin, Index end) {
  const Index* const vertex = mesh.vertex().data();
  if (end - begin == 4) {
    return 0.25 * ((in[vertex[begin]] + in[vertex[begin + 2]]) +
                   (in[vertex[begin + 1]] + in[vertex[begin + 3]]));
  }
  Vec3 sum = in[vertex[begin]];
  for (Index h = begin + 1; h < end; ++h) sum += in[vertex[h]];
  return (1.0 / (end - begin)) * sum;
}

// The neighbours of a vertex, for its smooth point.
template <class Walk>
class Star {
 public:
  Star(const HalfEdgeMesh& mesh, const Vec3* points, const Vec3* centroids, double bilinear)
      : walk_(mesh),
        vertex_(mesh.vertex().data()),
        points_(points),
        centroids_(centroids),
        bilinear_(bilinear) {}

  void Add(Index h) {
    ends_ += points_[vertex_[walk_.Next(h)]];
    faces_ += centroids_[walk_.Face(h)];
    ++n_;
  }
  Vec3 Point(const Vec3& own) const {
    const double inverse = 1.0 / n_;
    const double around = (1 - bilinear_) * inverse * inverse;
    return (1 - 2 * (1 - bilinear_) * inverse) * own + around * (ends_ + faces_);
  }

 private:
  const Walk walk_;
  const Index* vertex_;
  const Vec3* points_;
  const Vec3* centroids_;
  double bilinear_;
  Vec3 ends_ = {0, 0, 0};
  Vec3 faces_ = {0, 0, 0};
  Index n_ = 0;
};

template <class Walk>
absl::Status RefineEdges(const Context& context, const SurfaceLevel& level, const Vec3* in,
                         Vec3* refined, double bilinear) {
  const HalfEdgeMesh& mesh = level.mesh;
  const Vec3* const centroids = refined + mesh.vertex_count() + mesh.edge_count();
  Vec3* const out = refined + mesh.vertex_count();
  const Walk walk(mesh);
  const bool creased = level.sharpness.creased();
  return ParallelFor(context, mesh.edge_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const Index h = mesh.edge_half_edge()[e];
      const Index t = mesh.twin()[h];
      const Vec3 ends = in[mesh.vertex()[h]] + in[mesh.vertex()[walk.Next(h)]];
      const Vec3 middle = 0.5 * ends;
      if (t == kNoIndex) {
        out[e] = middle;
        continue;
      }
      Vec3 smooth = 0.25 * (ends + (centroids[walk.Face(h)] + centroids[walk.Face(t)]));
      if (bilinear != 0) smooth = bilinear * middle + (1 - bilinear) * smooth;
      out[e] = creased ? BlendEdge(level.sharpness.edge[e], middle, smooth) : smooth;
    }
  });
}

template <class Walk>
absl::Status Refine(const Context& context, const SurfaceLevel& level, const Vec3* in,
                    Vec3* refined, double bilinear) {
  const HalfEdgeMesh& mesh = level.mesh;
  Vec3* const centroids = refined + mesh.vertex_count() + mesh.edge_count();
  const Walk walk(mesh);
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.face_count(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (Index f = static_cast<Index>(begin); f < end; ++f) {
          centroids[f] = CentroidOf(mesh, in, walk.FaceBegin(f), walk.FaceEnd(f));
        }
      }));
  LIMN_RETURN_IF_ERROR(RefineEdges<Walk>(context, level, in, refined, bilinear));
  const Star<Walk> star(mesh, in, centroids, bilinear);
  return VertexRefiner<Walk, Star<Walk>>(level, in, star).Run(context, refined);
}

}  // namespace

absl::Status RefineCatmullClark(const Context& context, const SurfaceLevel& level,
                                absl::Span<const Vec3> points, absl::Span<Vec3> refined,
                                double bilinear) {
  const HalfEdgeMesh& mesh = level.mesh;
  LIMN_RETURN_IF_ERROR(CheckRefinedSizes(level, points.size(), refined.size(), mesh.face_count()));
  return WithWalk(mesh, [&](auto walk) {
    return Refine<decltype(walk)>(context, level, points.data(), refined.data(), bilinear);
  });
}

}  // namespace limn
