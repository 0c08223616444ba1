// SPDX-License-Identifier: MIT
#include "engine/limit/chord_coarse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/base/buffer.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/limit/doo_sabin_limit.h"
#include "engine/limit/patch_cones.h"
#include "engine/limit/ring_deviation.h"
#include "engine/refine/average_normal.h"

namespace limn {
namespace {

constexpr std::size_t kFaceGrain = 256;

double DistanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double square = Dot(along, along);
  const double t = square > 0 ? std::clamp(Dot(p - a, along) / square, 0.0, 1.0) : 0;
  return Norm(p - (a + t * along));
}

// vertex[j][i]: the vertices of the four quads of T^2 in a quad of T^1, as in a patch.
using NineVertices = std::array<std::array<Vec3, 3>, 3>;

PatchBound BoundOf(const NineVertices& vertex) {
  const auto& [low, middle, high] = vertex;
  const Vec3 du = (low[2] - low[0]) + (high[2] - high[0]);
  const Vec3 dv = (high[0] - low[0]) + (high[2] - low[2]);
  const Vec3 normal = UnitCross(du, dv, 2 * MaxAbs(middle[1]));
  std::array<Vec3, 6> u{};
  std::array<Vec3, 6> v{};
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      u[2 * j + i] = 2 * (vertex[j][i + 1] - vertex[j][i]);
      v[2 * j + i] = 2 * (vertex[i + 1][j] - vertex[i][j]);
    }
  }
  ProductCone products(normal);
  products.Add(u, v);
  Deviation delta;
  const auto widen = [&](const Vec3& p, const Vec3& a, const Vec3& b) {
    delta.Widen(PartsOf(p - 0.5 * (a + b), normal));
  };
  widen(low[1], low[0], low[2]);
  widen(high[1], high[0], high[2]);
  widen(middle[0], low[0], high[0]);
  widen(middle[2], low[2], high[2]);
  widen(middle[1], 0.5 * (low[0] + low[2]), 0.5 * (high[0] + high[2]));
  // Both tessellations are split by any diagonals.
  Deviation split;
  for (std::size_t j = 0; j < 2; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 twist =
          (vertex[j][i] - vertex[j][i + 1]) - (vertex[j + 1][i] - vertex[j + 1][i + 1]);
      split.Widen(0.25 * PartsOf(twist, normal));
    }
  }
  const Deviation coarse = 0.25 * PartsOf((low[0] - low[2]) - (high[0] - high[2]), normal);
  return {products.Cone(), delta + split + coarse};
}

class Coarse {
 public:
  Coarse(const Context& context, const CoarseSurface& surface)
      : context_(context), surface_(surface) {}

  absl::StatusOr<CoarseChords> Run() {
    const HalfEdgeMesh& split = surface_.split;
    points_.resize(split.vertex_count() + split.edge_count() + split.face_count());
    LIMN_RETURN_IF_ERROR(DooSabinLimit(
        context_, {.mesh = split, .fans = surface_.fans, .k = 2, .boundary = &surface_.boundary},
        surface_.corners, {.points = absl::MakeSpan(points_), .normals = {}}));
    CoarseChords chords;
    LIMN_RETURN_IF_ERROR(FirstToSecond(&chords.first_to_second));
    LIMN_RETURN_IF_ERROR(PolygonsToFirst(&chords.polygons_to_first));
    return chords;
  }

 private:
  NineVertices VerticesOf(Index quad) const {
    const HalfEdgeMesh& split = surface_.split;
    const auto corner = [&](Index i) { return points_[split.vertex()[4 * quad + i]]; };
    const auto side = [&](Index i) {
      return points_[split.vertex_count() + split.edge()[4 * quad + i]];
    };
    const Vec3 middle = points_[split.vertex_count() + split.edge_count() + quad];
    return {{{corner(0), side(0), corner(1)},
             {side(3), middle, side(1)},
             {corner(3), side(2), corner(2)}}};
  }

  absl::Status FirstToSecond(double* result) {
    Buffer<PatchBound> quads(surface_.base.half_edge_count());
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, quads.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t q = begin; q < end; ++q)
            quads[q] = BoundOf(VerticesOf(static_cast<Index>(q)));
        }));
    double curve = 0;
    LIMN_RETURN_IF_ERROR(Curve(&curve));
    LIMN_ASSIGN_OR_RETURN(const PatchCones cones, PatchCones::Make(context_, surface_.base, quads));
    return ParallelMax(
        context_, quads.size(), 0,
        [&](std::size_t begin, std::size_t end) {
          double largest = 0;
          for (std::size_t q = begin; q < end; ++q) {
            const PatchCones::Surroundings around = cones.Around(static_cast<Index>(q));
            largest = std::max(largest, DistanceBound(around.deviation, around.cone, 1) +
                                            (around.at_boundary ? curve : 0));
          }
          return largest;
        },
        result);
  }

  // How far T^2's boundary is from T^1's across it, or at the same parameter where it turns back.
  absl::Status Curve(double* result) {
    const BoundaryCurve& boundary = surface_.boundary;
    return ParallelMax(
        context_, boundary.size(), 0,
        [&](std::size_t begin, std::size_t end) {
          double largest = 0;
          for (std::size_t i = begin; i < end; ++i) {
            const Vec3& from = boundary.centre[i];
            const Vec3& to = boundary.centre[boundary.next[i]];
            const Vec3 middle = 0.5 * (boundary.start[i] + boundary.end[i]);
            const bool forward =
                Dot(middle - from, to - from) >= 0 && Dot(to - middle, to - from) >= 0;
            largest = std::max(largest, forward ? DistanceToSegment(middle, from, to)
                                                : Norm(middle - 0.5 * (from + to)));
          }
          return largest;
        },
        result);
  }

  absl::Status PolygonsToFirst(double* result) {
    return ParallelMax(
        context_, surface_.base.face_count(), 0,
        [&](std::size_t begin, std::size_t end) {
          double largest = 0;
          std::vector<Vec3> corner;
          std::vector<Vec3> side;
          for (std::size_t f = begin; f < end; ++f) {
            corner.clear();
            side.clear();
            const HalfEdgeMesh& base = surface_.base;
            for (Index h = base.face_begin()[f]; h < base.face_begin()[f + 1]; ++h) {
              corner.push_back(points_[base.vertex()[h]]);
              side.push_back(points_[base.vertex_count() + base.edge()[h]]);
            }
            const Vec3 middle = points_[base.vertex_count() + base.edge_count() + f];
            largest = std::max(largest, PolygonToFan(corner, side, middle));
          }
          return largest;
        },
        result);
  }

  static double PolygonToFan(absl::Span<const Vec3> corner, absl::Span<const Vec3> side,
                             const Vec3& middle) {
    const std::size_t m = corner.size();
    double radius = 0;
    double off_edge = 0;
    for (std::size_t i = 0; i < m; ++i) {
      radius = std::max({radius, Norm(corner[i] - middle), Norm(side[i] - middle)});
      off_edge = std::max(off_edge, DistanceToSegment(side[i], corner[i], corner[(i + 1) % m]));
    }
    const Vec3 normal = AverageNormal(m, middle, [&](std::size_t i) { return corner[i]; });
    if (!ConvexAround(corner, middle, normal)) return 2 * radius;
    double low = 0;
    double high = 0;
    for (std::size_t i = 0; i < m; ++i) {
      for (const Vec3& p : {corner[i], side[i]}) {
        low = std::min(low, Dot(p - middle, normal));
        high = std::max(high, Dot(p - middle, normal));
      }
    }
    return std::min(2 * radius, (high - low) + 2 * off_edge);
  }

  // Whether a polygon is strictly convex and winds once around a point inside, seen along a normal.
  static bool ConvexAround(absl::Span<const Vec3> corner, const Vec3& middle, const Vec3& normal) {
    const std::size_t m = corner.size();
    if (normal == Vec3{0, 0, 0}) return false;
    double turn = 0;
    for (std::size_t i = 0; i < m; ++i) {
      const Vec3 along = corner[(i + 1) % m] - corner[i];
      const Vec3 onward = corner[(i + 2) % m] - corner[(i + 1) % m];
      if (!(Dot(normal, Cross(along, middle - corner[i])) >= 0)) return false;
      const double sine = Dot(normal, Cross(along, onward));
      if (!(sine > 0)) return false;
      const double cosine = Dot(along, onward) - Dot(along, normal) * Dot(onward, normal);
      turn += std::atan2(sine, cosine);
    }
    return turn < 6 * kRightAngle;
  }

  const Context& context_;
  const CoarseSurface& surface_;
  // Of T^2.
  Buffer<Vec3> points_;
};

}  // namespace

absl::StatusOr<CoarseChords> BoundCoarseLevels(const Context& context,
                                               const CoarseSurface& surface) {
  return Coarse(context, surface).Run();
}

}  // namespace limn
