// SPDX-License-Identifier: MIT
#include "engine/refine/doo_sabin_refine.h"

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/doo_sabin_rule.h"

namespace limn {
namespace {

// Faces per chunk: each writes at least 16 points.
constexpr std::size_t kFaceGrain = 512;

// The images that lie in type-E faces: those of corner h across its own edge and across the edge
// that enters it. kOpen: those of boundary edges are left out.
template <bool kOpen, class Walk>
void EdgeImages(const Walk& walk, absl::Span<const Index> twin, const Vec3* in, Index h,
                Vec3* out) {
  const Index next = walk.Next(h);
  const Index prev = walk.Prev(h);
  const Index across = twin[h];
  const Index across_prev = twin[prev];
  if (!kOpen || across != kNoIndex) {
    out[1] = QuadImage(in[h], in[next], in[walk.Next(across)], in[across]);
  }
  if (!kOpen || across_prev != kNoIndex) {
    out[3] = QuadImage(in[h], in[prev], in[across_prev], in[walk.Next(across_prev)]);
  }
}

template <bool kOpen>
absl::Status RefinePolygons(const Context& context, const HalfEdgeMesh& mesh, const Vec3* in,
                            Vec3* out) {
  const PolygonWalk walk(mesh);
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.face_count(), kFaceGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          const Index first = mesh.face_begin()[f];
          const Index last = mesh.face_begin()[f + 1];
          FaceImages(
              last - first, [&](std::size_t i) { return in[first + i]; },
              [&](std::size_t i, const Vec3& image) { out[4 * (first + i) + 2] = image; });
          for (Index h = first; h < last; ++h) {
            EdgeImages<kOpen>(walk, mesh.twin(), in, h, out + 4 * std::size_t{h});
          }
        }
      }));
  return ParallelFor(
      context, mesh.vertex_count(), kFaceGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          const Index* const fan = mesh.fan().data() + mesh.fan_begin()[v];
          if (kOpen && mesh.twin()[fan[0]] == kNoIndex) continue;
          FaceImages(
              mesh.valence(v), [&](std::size_t i) { return in[fan[i]]; },
              [&](std::size_t i, const Vec3& image) { out[4 * std::size_t{fan[i]}] = image; });
        }
      });
}

// The image of quad corner h in its type-V face, as if the vertex were regular.
template <bool kOpen>
void RegularVertexImage(const QuadWalk& walk, absl::Span<const Index> twin, const Vec3* in, Index h,
                        Vec3* out) {
  const Index ccw = RotateCcw(walk, twin, h);
  const Index cw = RotateCw(walk, twin, h);
  if (kOpen && (ccw == kNoIndex || cw == kNoIndex)) return;
  const Index opposite = RotateCcw(walk, twin, ccw);
  if (kOpen && opposite == kNoIndex) return;
  out[0] = QuadImage(in[h], in[ccw], in[cw], in[opposite]);
}

// T^(k-1) of quads: every vertex is taken as regular first, which writes some wrong images at the
// few extraordinary ones; these are written again from their fans, those of boundary vertices by
// RefineAlongBoundary.
template <bool kOpen>
absl::Status RefineQuads(const Context& context, const DooSabinLevel& level, const Vec3* in,
                         Vec3* out) {
  const HalfEdgeMesh& mesh = level.mesh;
  const absl::Span<const Index> twin = mesh.twin();
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.face_count(), kFaceGrain, [&](std::size_t begin, std::size_t end) {
        const QuadWalk walk(mesh);
        for (Index h = static_cast<Index>(4 * begin); h < 4 * end; ++h) {
          Vec3* const image = out + 4 * std::size_t{h};
          EdgeImages<kOpen>(walk, twin, in, h, image);
          image[2] =
              QuadImage(in[h], in[walk.Next(h)], in[walk.Prev(h)], in[walk.Next(walk.Next(h))]);
          RegularVertexImage<kOpen>(walk, twin, in, h, image);
        }
      }));
  const ExtraordinaryFans& fans = level.fans;
  // A corner of T^1 has number c * 4^j as the corner of T^(1+j) at the same vertex.
  const std::uint32_t shift = 2 * (level.k - 2);
  return ParallelFor(context, fans.vertex.size(), kFaceGrain,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t i = begin; i < end; ++i) {
                         const Index* const fan = fans.corner.data() + fans.begin[i];
                         FaceImages(
                             fans.begin[i + 1] - fans.begin[i],
                             [&](std::size_t j) { return in[std::size_t{fan[j]} << shift]; },
                             [&](std::size_t j, const Vec3& image) {
                               out[(std::size_t{fan[j]} << shift) * 4] = image;
                             });
                       }
                     });
}

// The images in the faces that ghosts complete.
absl::Status RefineAlongBoundary(const Context& context, const DooSabinLevel& level, const Vec3* in,
                                 Vec3* out) {
  const HalfEdgeMesh& mesh = level.mesh;
  const BoundaryCurve& curve = *level.boundary;
  return ParallelFor(context, curve.size(), kFaceGrain, [&](std::size_t begin, std::size_t end) {
    BoundaryFace face;
    for (std::size_t i = begin; i < end; ++i) {
      const Index number = static_cast<Index>(i);
      const std::size_t h = curve.half_edge[i];
      const auto [b, a, ghost_a, ghost_b] = BoundaryEdgeFace(mesh, curve, in, number);
      out[4 * h + 1] = QuadImage(a, b, ghost_a, ghost_b);
      const std::size_t next =
          WithWalk(mesh, [&](auto walk) { return walk.Next(curve.half_edge[i]); });
      out[4 * next + 3] = QuadImage(b, a, ghost_b, ghost_a);
      GatherBoundaryFace(mesh, curve, in, number, &face);
      FaceImages(
          face.point.size(), [&](std::size_t j) { return face.point[j]; },
          [&](std::size_t j, const Vec3& image) {
            if (j < face.corner.size()) out[4 * std::size_t{face.corner[j]}] = image;
          });
    }
  });
}

bool IsExtraordinary(const HalfEdgeMesh& mesh, std::size_t v) {
  return mesh.valence(v) != 4 && mesh.twin()[mesh.fan()[mesh.fan_begin()[v]]] != kNoIndex;
}

// Growing step by step would take twice the memory.
void ReserveFans(const HalfEdgeMesh& mesh, ExtraordinaryFans* fans) {
  std::size_t count = 0;
  std::size_t corners = 0;
  const auto add = [&](std::size_t size) {
    ++count;
    corners += size;
  };
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (IsExtraordinary(mesh, v)) add(mesh.valence(v));
  }
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const std::size_t arity = mesh.face_begin()[f + 1] - mesh.face_begin()[f];
    if (arity != 4) add(arity);
  }
  fans->vertex.reserve(count);
  fans->begin.reserve(count + 1);
  fans->corner.reserve(corners);
}

}  // namespace

absl::Status FirstRefinement(const Context& context, const HalfEdgeMesh& mesh,
                             absl::Span<const Vec3> control, absl::Span<Vec3> corners,
                             FirstRule rule) {
  const absl::Span<const Index> vertex = mesh.vertex();
  return ParallelFor(
      context, mesh.face_count(), kFaceGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          const Index first = mesh.face_begin()[f];
          const Index last = mesh.face_begin()[f + 1];
          if (rule == FirstRule::kStandard) {
            FaceImages(
                last - first, [&](std::size_t i) { return control[vertex[first + i]]; },
                [&](std::size_t i, const Vec3& image) { corners[first + i] = image; });
            continue;
          }
          Vec3 sum = control[vertex[first]];
          for (Index h = first + 1; h < last; ++h) sum += control[vertex[h]];
          const Vec3 half_centroid = (0.5 / (last - first)) * sum;
          for (Index h = first; h < last; ++h) {
            corners[h] = 0.5 * control[vertex[h]] + half_centroid;
          }
        }
      });
}

absl::StatusOr<ExtraordinaryFans> FindExtraordinaryFans(const Context& context,
                                                        const HalfEdgeMesh& mesh) {
  LIMN_RETURN_IF_ERROR(context.Check());
  ExtraordinaryFans fans;
  ReserveFans(mesh, &fans);
  fans.begin.push_back(0);
  const auto close = [&](std::size_t vertex) {
    fans.vertex.push_back(static_cast<Index>(vertex));
    fans.begin.push_back(static_cast<Index>(fans.corner.size()));
  };
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    if (!IsExtraordinary(mesh, v)) continue;
    for (Index i = mesh.fan_begin()[v]; i < mesh.fan_begin()[v + 1]; ++i) {
      fans.corner.push_back(4 * mesh.fan()[i]);
    }
    close(v);
  }
  LIMN_RETURN_IF_ERROR(context.Check());
  const std::size_t first_face = mesh.vertex_count() + mesh.edge_count();
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Index begin = mesh.face_begin()[f];
    const Index end = mesh.face_begin()[f + 1];
    if (end - begin == 4) continue;
    for (Index h = begin; h < end; ++h) fans.corner.push_back(4 * h + 2);
    close(first_face + f);
  }
  return fans;
}

absl::Status RefineDooSabin(const Context& context, const DooSabinLevel& level,
                            absl::Span<const Vec3> corners, absl::Span<Vec3> refined) {
  const Vec3* const in = corners.data();
  Vec3* const out = refined.data();
  if (!level.open()) {
    if (level.k == 1) return RefinePolygons<false>(context, level.mesh, in, out);
    return RefineQuads<false>(context, level, in, out);
  }
  LIMN_RETURN_IF_ERROR(level.k == 1 ? RefinePolygons<true>(context, level.mesh, in, out)
                                    : RefineQuads<true>(context, level, in, out));
  return RefineAlongBoundary(context, level, in, out);
}

}  // namespace limn
