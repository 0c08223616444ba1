// SPDX-License-Identifier: MIT
#include "engine/limit/vertex_limit.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/limit/gather_ring.h"
#include "engine/mesh/triangle_split.h"

namespace limn {
namespace {

constexpr std::size_t kGrain = 512;

absl::Status CheckSizes(const SurfaceLevel& level, std::size_t points, const VertexLimits& limits) {
  const std::size_t size = limits.points.size();
  const auto fits = [&](std::size_t n) { return n == 0 || n == size; };
  if (points == level.mesh.vertex_count() && size <= points && fits(limits.tangents.size()) &&
      fits(limits.normals.size())) {
    return absl::OkStatus();
  }
  return MakeError(absl::StrCat("no room of ", size, " limits for ", points, " points of ",
                                level.mesh.vertex_count(), " vertices"),
                   {.reason = Reason::kInternal});
}

// Rings of refined meshes, and of any triangles.
template <class Walk, RingKind kKind>
class PlainRings {
 public:
  static constexpr RingKind kRingKind = kKind;

  explicit PlainRings(const LevelPoints& level) : level_(level), walk_(level.mesh) {}

  // The most frequent ring, without memory. False when v has another one.
  bool Regular(std::size_t v, bool with_tangents, VertexFrame* frame) const {
    constexpr std::size_t kValence = kKind == RingKind::kQuads ? 4 : 6;
    const Sharpness& sharpness = level_.sharpness;
    if (sharpness.creased() && sharpness.vertex[v] > 0) return false;
    const absl::Span<const Index> twin = level_.mesh.twin();
    const Index start = level_.mesh.vertex_half_edge()[v];
    std::array<Index, kValence> fan = {start};
    if (level_.SharpnessOf(start) > 0) return false;
    for (std::size_t i = 1; i < kValence; ++i) {
      fan[i] = RotateCcw(walk_, twin, fan[i - 1]);
      if (fan[i] == kNoIndex || fan[i] == start || level_.SharpnessOf(fan[i]) > 0) return false;
    }
    if (RotateCcw(walk_, twin, fan.back()) != start) return false;
    const Vec3& point = level_.in[v];
    if constexpr (kKind == RingKind::kQuads) {
      RegularQuads(point, fan, with_tangents, frame);
    } else {
      RegularTriangles(point, fan, with_tangents, frame);
    }
    return true;
  }

  void Gather(std::size_t v, VertexRing* ring) const {
    GatherRing<kKind>(
        level_, walk_, level_.mesh.vertex_half_edge()[v], [&](Index h) { return Across(h); }, ring);
    SettleRing(kRingKind, ring);
  }

 private:
  const Vec3& End(Index h) const { return level_.in[level_.mesh.vertex()[walk_.Next(h)]]; }
  const Vec3& Across(Index h) const {
    return level_.in[level_.mesh.vertex()[walk_.Next(walk_.Next(h))]];
  }

  void RegularQuads(const Vec3& point, const std::array<Index, 4>& fan, bool with_tangents,
                    VertexFrame* frame) const {
    const Vec3 e[4] = {End(fan[0]), End(fan[1]), End(fan[2]), End(fan[3])};
    const Vec3 f[4] = {Across(fan[0]), Across(fan[1]), Across(fan[2]), Across(fan[3])};
    frame->point = (4 / 9.0) * point + (1 / 9.0) * ((e[0] + e[2]) + (e[1] + e[3])) +
                   (1 / 36.0) * ((f[0] + f[2]) + (f[1] + f[3]));
    if (!with_tangents) return;
    const Vec3 one = f[0] - f[2];
    const Vec3 other = f[1] - f[3];
    frame->tangents.u = (1 / 3.0) * (e[0] - e[2]) + (1 / 12.0) * (one - other);
    frame->tangents.v = (1 / 3.0) * (e[1] - e[3]) + (1 / 12.0) * (one + other);
  }

  void RegularTriangles(const Vec3& point, const std::array<Index, 6>& fan, bool with_tangents,
                        VertexFrame* frame) const {
    const Vec3 e[6] = {End(fan[0]), End(fan[1]), End(fan[2]),
                       End(fan[3]), End(fan[4]), End(fan[5])};
    frame->point = 0.5 * point + (1 / 12.0) * ((e[0] + e[3]) + (e[1] + e[4]) + (e[2] + e[5]));
    if (!with_tangents) return;
    const Vec3 one = e[1] - e[4];
    const Vec3 other = e[2] - e[5];
    static const double kRoot3 = std::sqrt(3.0);
    frame->tangents.u = (1 / 3.0) * (e[0] - e[3]) + (1 / 6.0) * (one - other);
    frame->tangents.v = (kRoot3 / 6) * (one + other);
  }

  const LevelPoints& level_;
  const Walk walk_;
};

// Rings of T^1 around the vertices of T^0, for faces of any arity.
class FirstRings {
 public:
  static constexpr RingKind kRingKind = RingKind::kQuads;

  FirstRings(const LevelPoints& level, const Vec3* centroids)
      : level_(level), walk_(level.mesh), centroids_(centroids) {}

  static bool Regular(std::size_t /*v*/, bool /*with_tangents*/, VertexFrame* /*frame*/) {
    return false;
  }

  void Gather(std::size_t v, VertexRing* ring) const {
    GatherRing<kRingKind>(
        level_, walk_, level_.mesh.vertex_half_edge()[v],
        [&](Index h) { return centroids_[level_.mesh.face()[h]]; }, ring);
    RefineRing(kRingKind, true, ring);
    SettleRing(kRingKind, ring);
  }

 private:
  const LevelPoints& level_;
  const PolygonWalk walk_;
  const Vec3* centroids_;
};

template <class Rings>
absl::Status WriteLimits(const Context& context, const Rings& rings, const VertexLimits& limits) {
  const bool with_tangents = !limits.tangents.empty() || !limits.normals.empty();
  return ParallelFor(
      context, limits.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        VertexRing ring;
        VertexFrame frame;
        for (std::size_t v = begin; v < end; ++v) {
          if (rings.Regular(v, with_tangents, &frame)) {
            if (!limits.normals.empty()) {
              frame.normal = UnitCross(frame.tangents.u, frame.tangents.v, MaxAbs(frame.point));
            }
          } else {
            rings.Gather(v, &ring);
            if (with_tangents) {
              frame = RingFrame(Rings::kRingKind, ring);
            } else {
              frame.point = RingPoint(Rings::kRingKind, ring);
            }
          }
          limits.points[v] = frame.point;
          if (!limits.tangents.empty()) limits.tangents[v] = frame.tangents;
          if (!limits.normals.empty()) limits.normals[v] = frame.normal;
        }
      });
}

absl::StatusOr<Buffer<Vec3>> Centroids(const Context& context, const LevelPoints& level) {
  const HalfEdgeMesh& mesh = level.mesh;
  Buffer<Vec3> centroids(mesh.face_count());
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh.face_count(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          const Index first = mesh.face_begin()[f];
          const Index last = mesh.face_begin()[f + 1];
          Vec3 sum = {0, 0, 0};
          for (Index h = first; h < last; ++h) sum += level.in[mesh.vertex()[h]];
          centroids[f] = (1.0 / (last - first)) * sum;
        }
      }));
  return centroids;
}

}  // namespace

absl::Status CatmullClarkLimits(const Context& context, const SurfaceLevel& level,
                                absl::Span<const Vec3> points, const VertexLimits& limits) {
  LIMN_RETURN_IF_ERROR(CheckSizes(level, points.size(), limits));
  const LevelPoints in(level, points);
  if (level.mesh.arity() == 3) {
    return MakeError("triangles that Loop's split made have no Catmull-Clark limits",
                     {.reason = Reason::kInternal});
  }
  if (level.mesh.arity() == 4) {
    return WriteLimits(context, PlainRings<QuadWalk, RingKind::kQuads>(in), limits);
  }
  LIMN_ASSIGN_OR_RETURN(const Buffer<Vec3> centroids, Centroids(context, in));
  return WriteLimits(context, FirstRings(in, centroids.data()), limits);
}

absl::Status LoopLimits(const Context& context, const SurfaceLevel& level,
                        absl::Span<const Vec3> points, const VertexLimits& limits) {
  LIMN_RETURN_IF_ERROR(RequireTriangles(level.mesh));
  LIMN_RETURN_IF_ERROR(CheckSizes(level, points.size(), limits));
  const LevelPoints in(level, points);
  return WriteLimits(context, PlainRings<TriangleWalk, RingKind::kTriangles>(in), limits);
}

}  // namespace limn
