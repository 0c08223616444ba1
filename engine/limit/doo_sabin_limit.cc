// SPDX-License-Identifier: MIT
#include "engine/limit/doo_sabin_limit.h"

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/harmonics.h"

namespace limn {
namespace {

// Normal of the limit surface at the centroid of an m-gon, m other than 4.
Vec3 PolygonNormal(std::size_t m, const Harmonics& f) {
  return UnitCross(f.t1, f.t2, static_cast<double>(m) * MaxAbs(f.mean));
}

Vec3 QuadNormal(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return UnitCross(a - c, b - d, MaxAbs(a));
}

Vec3 FaceNormal(absl::Span<const Vec3> p) {
  if (p.size() == 4) return QuadNormal(p[0], p[1], p[2], p[3]);
  return PolygonNormal(p.size(), FirstHarmonics(p.size(), [&](std::size_t i) { return p[i]; }));
}

// Writes limit points and normals of faces of M^k.
class FaceLimits {
 public:
  FaceLimits(const Vec3* corners, const LimitOutput& output)
      : in_(corners),
        points_(output.points.data()),
        normals_(output.normals.empty() ? nullptr : output.normals.data()) {}

  void Quad(std::size_t at, std::size_t a, std::size_t b, std::size_t c, std::size_t d) const {
    points_[at] = 0.25 * ((in_[a] + in_[c]) + (in_[b] + in_[d]));
    if (normals_ != nullptr) {
      normals_[at] = QuadNormal(in_[a], in_[b], in_[c], in_[d]);
    }
  }

  // corner(i): number of the face's i-th corner.
  template <class Corner>
  void Polygon(std::size_t at, std::size_t m, const Corner& corner) const {
    if (m == 4) return Quad(at, corner(0), corner(1), corner(2), corner(3));
    if (normals_ == nullptr) {
      points_[at] = Mean(m, corner);
      return;
    }
    const Harmonics f = FirstHarmonics(m, [&](std::size_t i) { return in_[corner(i)]; });
    points_[at] = f.mean;
    normals_[at] = PolygonNormal(m, f);
  }

 private:
  // As FirstHarmonics computes it, to the bit.
  template <class Corner>
  Vec3 Mean(std::size_t m, const Corner& corner) const {
    const Vec3 origin = in_[corner(0)];
    Vec3 sum = {0, 0, 0};
    for (std::size_t i = 1; i < m; ++i) sum += in_[corner(i)] - origin;
    return origin + (1.0 / static_cast<double>(m)) * sum;
  }

  const Vec3* in_;
  Vec3* points_;
  Vec3* normals_;
};

// kOpen: boundary vertices and edges are left to BoundaryLimits.
template <bool kOpen>
absl::Status VertexLimits(const Context& context, const DooSabinLevel& level,
                          const FaceLimits& limits) {
  const HalfEdgeMesh& mesh = level.mesh;
  if (level.k == 1) {
    return ParallelFor(context, mesh.vertex_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const Index* const fan = mesh.fan().data() + mesh.fan_begin()[v];
        if (kOpen && mesh.twin()[fan[0]] == kNoIndex) continue;
        limits.Polygon(v, mesh.valence(v), [&](std::size_t i) { return fan[i]; });
      }
    });
  }
  // As in refinement: all as regular first, then the extraordinary ones.
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.vertex_count(), [&](std::size_t begin, std::size_t end) {
        const QuadWalk walk(mesh);
        for (std::size_t v = begin; v < end; ++v) {
          const Index a = mesh.vertex_half_edge()[v];
          // At a boundary it is the half-edge along it.
          if (kOpen && mesh.twin()[a] == kNoIndex) continue;
          const Index b = RotateCcw(walk, mesh.twin(), a);
          const Index c = RotateCcw(walk, mesh.twin(), b);
          limits.Quad(v, a, b, c, RotateCcw(walk, mesh.twin(), c));
        }
      }));
  const ExtraordinaryFans& fans = level.fans;
  const std::uint32_t shift = 2 * (level.k - 2);
  return ParallelFor(context, fans.vertex.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index* const fan = fans.corner.data() + fans.begin[i];
      limits.Polygon(fans.vertex[i], fans.begin[i + 1] - fans.begin[i],
                     [&](std::size_t j) { return std::size_t{fan[j]} << shift; });
    }
  });
}

template <bool kOpen, class Walk>
absl::Status EdgeAndFaceLimits(const Context& context, const Walk& walk, const HalfEdgeMesh& mesh,
                               const FaceLimits& limits) {
  const std::size_t first_edge = mesh.vertex_count();
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.edge_count(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) {
          const Index h = mesh.edge_half_edge()[e];
          const Index t = mesh.twin()[h];
          if (kOpen && t == kNoIndex) continue;
          limits.Quad(first_edge + e, walk.Next(h), h, walk.Next(t), t);
        }
      }));
  const std::size_t first_face = first_edge + mesh.edge_count();
  return ParallelFor(context, mesh.face_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const Index first = walk.FaceBegin(static_cast<Index>(f));
      limits.Polygon(first_face + f, walk.FaceEnd(static_cast<Index>(f)) - first,
                     [&](std::size_t i) { return first + i; });
    }
  });
}

// Points of the curve, and normals of the faces that ghosts complete.
absl::Status BoundaryLimits(const Context& context, const DooSabinLevel& level, const Vec3* corners,
                            const LimitOutput& output) {
  const HalfEdgeMesh& mesh = level.mesh;
  const BoundaryCurve& curve = *level.boundary;
  return ParallelFor(context, curve.size(), [&](std::size_t begin, std::size_t end) {
    BoundaryFace face;
    for (std::size_t i = begin; i < end; ++i) {
      const Index number = static_cast<Index>(i);
      const std::size_t vertex = mesh.vertex()[curve.half_edge[i]];
      const std::size_t edge = mesh.vertex_count() + mesh.edge()[curve.half_edge[i]];
      output.points[vertex] = curve.centre[i] - curve.origin;
      if (!output.vertices_only) {
        output.points[edge] = 0.5 * (curve.start[i] + curve.end[i]) - curve.origin;
      }
      if (output.normals.empty()) continue;
      GatherBoundaryFace(mesh, curve, corners, number, &face);
      output.normals[vertex] = FaceNormal(face.point);
      if (!output.vertices_only) {
        output.normals[edge] = FaceNormal(BoundaryEdgeFace(mesh, curve, corners, number));
      }
    }
  });
}

template <bool kOpen>
absl::Status AllLimits(const Context& context, const DooSabinLevel& level, const Vec3* corners,
                       const LimitOutput& output) {
  const FaceLimits limits(corners, output);
  LIMN_RETURN_IF_ERROR(VertexLimits<kOpen>(context, level, limits));
  if (output.vertices_only) return absl::OkStatus();
  return WithWalk(level.mesh, [&](auto walk) {
    return EdgeAndFaceLimits<kOpen>(context, walk, level.mesh, limits);
  });
}

}  // namespace

absl::Status DooSabinLimit(const Context& context, const DooSabinLevel& level,
                           absl::Span<const Vec3> corners, const LimitOutput& output) {
  if (!level.open()) return AllLimits<false>(context, level, corners.data(), output);
  LIMN_RETURN_IF_ERROR(AllLimits<true>(context, level, corners.data(), output));
  return BoundaryLimits(context, level, corners.data(), output);
}

}  // namespace limn
