// SPDX-License-Identifier: MIT
#include "engine/refine/doo_sabin_refine.h"

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/harmonics.h"

namespace limn {
namespace {

// Faces per chunk: each writes at least 16 points.
constexpr std::size_t kFaceGrain = 512;

// [ZC Eq. 1] for a quad: the image of `own`.
Vec3 QuadImage(const Vec3& own, const Vec3& side_a, const Vec3& side_b, const Vec3& opposite) {
  return 0.0625 * (9.0 * own + 3.0 * (side_a + side_b) + opposite);
}

// [ZC Eq. 1] for an m-gon, by its eigenvalues: mean + h/2 + rest/4, where own = mean + h + rest and
// h = (2/m)(cos t1 + sin t2). get(i) is point i, put(i, image) takes its image.
template <class Get, class Put>
void PolygonImages(std::size_t m, const Get& get, const Put& put) {
  const Harmonics f = FirstHarmonics(m, get);
  const double scale = 0.5 / static_cast<double>(m);
  for (std::size_t i = 0; i < m; ++i) {
    const UnitAngle angle = AngleOf(i, m);
    put(i, 0.25 * get(i) + 0.75 * f.mean + scale * (angle.cos * f.t1 + angle.sin * f.t2));
  }
}

template <class Get, class Put>
void FaceImages(std::size_t m, const Get& get, const Put& put) {
  if (m != 4) return PolygonImages(m, get, put);
  const Vec3 p[4] = {get(0), get(1), get(2), get(3)};
  for (std::size_t i = 0; i < 4; ++i) {
    put(i, QuadImage(p[i], p[(i + 1) & 3], p[(i + 3) & 3], p[(i + 2) & 3]));
  }
}

// The images that lie in type-E faces: those of corner h across its own edge and across the edge
// that enters it.
template <class Walk>
void EdgeImages(const Walk& walk, absl::Span<const Index> twin, const Vec3* in, Index h,
                Vec3* out) {
  const Index next = walk.Next(h);
  const Index prev = walk.Prev(h);
  const Index across = twin[h];
  const Index across_prev = twin[prev];
  out[1] = QuadImage(in[h], in[next], in[walk.Next(across)], in[across]);
  out[3] = QuadImage(in[h], in[prev], in[across_prev], in[walk.Next(across_prev)]);
}

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
            EdgeImages(walk, mesh.twin(), in, h, out + 4 * std::size_t{h});
          }
        }
      }));
  return ParallelFor(
      context, mesh.vertex_count(), kFaceGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          const Index* const fan = mesh.fan().data() + mesh.fan_begin()[v];
          FaceImages(
              mesh.valence(v), [&](std::size_t i) { return in[fan[i]]; },
              [&](std::size_t i, const Vec3& image) { out[4 * std::size_t{fan[i]}] = image; });
        }
      });
}

// T^(k-1) of quads: every vertex is taken as regular first, which writes some wrong images at the
// few extraordinary ones; these are written again from their fans.
absl::Status RefineQuads(const Context& context, const DooSabinLevel& level, const Vec3* in,
                         Vec3* out) {
  const HalfEdgeMesh& mesh = level.mesh;
  const absl::Span<const Index> twin = mesh.twin();
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.face_count(), kFaceGrain, [&](std::size_t begin, std::size_t end) {
        const QuadWalk walk(mesh);
        for (Index h = static_cast<Index>(4 * begin); h < 4 * end; ++h) {
          Vec3* const image = out + 4 * std::size_t{h};
          EdgeImages(walk, twin, in, h, image);
          image[2] =
              QuadImage(in[h], in[walk.Next(h)], in[walk.Prev(h)], in[walk.Next(walk.Next(h))]);
          const Index ccw = RotateCcw(walk, twin, h);
          image[0] = QuadImage(in[h], in[ccw], in[RotateCw(walk, twin, h)],
                               in[RotateCcw(walk, twin, ccw)]);
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

// Growing step by step would take twice the memory.
void ReserveFans(const HalfEdgeMesh& mesh, ExtraordinaryFans* fans) {
  std::size_t count = 0;
  std::size_t corners = 0;
  const auto add = [&](std::size_t size) {
    if (size == 4) return;
    ++count;
    corners += size;
  };
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) add(mesh.valence(v));
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    add(mesh.face_begin()[f + 1] - mesh.face_begin()[f]);
  }
  fans->vertex.reserve(count);
  fans->begin.reserve(count + 1);
  fans->corner.reserve(corners);
}

}  // namespace

absl::Status FirstRefinement(const Context& context, const HalfEdgeMesh& mesh,
                             absl::Span<const Vec3> control, absl::Span<Vec3> corners) {
  return ParallelFor(context, mesh.face_count(), kFaceGrain,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t f = begin; f < end; ++f) {
                         const Index first = mesh.face_begin()[f];
                         const Index last = mesh.face_begin()[f + 1];
                         Vec3 sum = control[mesh.vertex()[first]];
                         for (Index h = first + 1; h < last; ++h) sum += control[mesh.vertex()[h]];
                         const Vec3 half_centroid = (0.5 / (last - first)) * sum;
                         for (Index h = first; h < last; ++h) {
                           corners[h] = 0.5 * control[mesh.vertex()[h]] + half_centroid;
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
    if (mesh.valence(v) == 4) continue;
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
  if (level.k == 1) return RefinePolygons(context, level.mesh, corners.data(), refined.data());
  return RefineQuads(context, level, corners.data(), refined.data());
}

}  // namespace limn
