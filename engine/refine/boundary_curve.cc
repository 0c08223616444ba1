// SPDX-License-Identifier: MIT
#include "engine/refine/boundary_curve.h"

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/harmonics.h"

namespace limn {
namespace {

// cos((j + 1/2) pi / m) / cos(pi / (2 m)) for j = 0 .. m - 1, m >= 2. Exactly 1 and -1 at the ends
// and odd about the middle, so that neighbours who see the boundary in opposite directions agree.
double Spread(std::size_t j, std::size_t m) {
  const std::size_t opposite = m - 1 - j;
  if (j > opposite) return -Spread(opposite, m);
  if (j == opposite) return 0;
  return AngleOf(2 * j + 1, 4 * m).cos / AngleOf(1, 4 * m).cos;
}

// cos((j + 1/2) pi / (2 m)) / cos(pi / (4 m)) for j = 0 .. m - 1, m >= 1. Exactly 1 at j = 0.
double QuarterSpread(std::size_t j, std::size_t m) {
  return AngleOf(2 * j + 1, 8 * m).cos / AngleOf(1, 8 * m).cos;
}

// The other three quarters of a sharp vertex' face. out and in are relative to its centre.
void AddQuarters(const Vec3& centre, const Vec3& out, const Vec3& in, BoundaryFace* face) {
  const std::size_t m = face->corner.size();
  const auto along_out = [&](std::size_t j) { return QuarterSpread(j, m) * out; };
  const auto along_in = [&](std::size_t j) { return QuarterSpread(m - 1 - j, m) * in; };
  for (std::size_t j = m; j-- > 0;) {
    face->point.push_back(2 * (centre + along_in(j)) - face->point[j]);
  }
  for (std::size_t j = 0; j < m; ++j) {
    face->point.push_back(face->point[j] - 2 * (along_out(j) + along_in(j)));
  }
  for (std::size_t j = m; j-- > 0;) {
    face->point.push_back(2 * (centre + along_out(j)) - face->point[j]);
  }
}

}  // namespace

Index BoundaryCurve::Find(Index h) const {
  return static_cast<Index>(std::lower_bound(half_edge.begin(), half_edge.end(), h) -
                            half_edge.begin());
}

absl::StatusOr<BoundaryCurve> FindBoundary(const Context& context, const HalfEdgeMesh& mesh) {
  BoundaryCurve curve;
  const std::size_t size = mesh.boundary_edge_count();
  if (size == 0) return curve;
  curve.half_edge.resize(size);
  curve.next.resize(size);
  curve.previous.resize(size);
  const absl::Span<const Index> twin = mesh.twin();
  std::uint64_t total = 0;
  LIMN_RETURN_IF_ERROR(ParallelNumber(
      context, twin.size(),
      [&](std::size_t begin, std::size_t end) {
        return static_cast<std::uint64_t>(
            std::count(twin.begin() + begin, twin.begin() + end, kNoIndex));
      },
      [&](std::size_t begin, std::size_t end, std::uint64_t first) {
        for (std::size_t h = begin; h < end; ++h) {
          if (twin[h] == kNoIndex) curve.half_edge[first++] = static_cast<Index>(h);
        }
      },
      &total));
  const PolygonWalk walk(mesh);
  LIMN_RETURN_IF_ERROR(ParallelFor(context, size, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      // The fan of a boundary vertex starts with the half-edge along the boundary.
      const Index to = mesh.vertex()[walk.Next(curve.half_edge[i])];
      curve.next[i] = curve.Find(mesh.vertex_half_edge()[to]);
      curve.previous[curve.next[i]] = static_cast<Index>(i);
    }
  }));
  return curve;
}

absl::Status PlaceBoundary(const Context& context, const BoundaryPlacement& placement,
                           BoundaryCurve* curve, double* residual) {
  const std::size_t size = curve->size();
  curve->centre.resize(size);
  curve->start.resize(size);
  curve->end.resize(size);
  LIMN_RETURN_IF_ERROR(ParallelFor(context, size, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3& from = placement.control[i];
      const Vec3& to = placement.control[curve->next[i]];
      curve->start[i] = 0.75 * from + 0.25 * to;
      curve->end[i] = 0.25 * from + 0.75 * to;
    }
  }));
  return ParallelMax(
      context, size, 0,
      [&](std::size_t begin, std::size_t end) {
        double largest = 0;
        for (std::size_t i = begin; i < end; ++i) {
          Vec3& out = curve->start[i];
          Vec3& in = curve->end[curve->previous[i]];
          const Vec3 mean = 0.5 * (out + in);
          curve->centre[i] = mean;
          const bool corner =
              placement.mesh.valence(placement.mesh.vertex()[curve->half_edge[i]]) == 1;
          if (!corner && placement.interpolated[i] == 0) continue;
          curve->centre[i] = placement.points[i];
          if (corner) continue;
          largest = std::max(largest, MaxAbs(placement.points[i] - mean));
          const Vec3 d = 0.5 * (out - in);
          out = placement.points[i] + d;
          in = placement.points[i] - d;
        }
        return largest;
      },
      residual);
}

void GatherBoundaryFace(const HalfEdgeMesh& mesh, const BoundaryCurve& curve, const Vec3* corners,
                        Index i, BoundaryFace* face) {
  face->corner.clear();
  face->point.clear();
  WithWalk(mesh, [&](auto walk) {
    for (Index h = curve.half_edge[i]; h != kNoIndex; h = RotateCcw(walk, mesh.twin(), h)) {
      face->corner.push_back(h);
      face->point.push_back(corners[h]);
    }
  });
  const Vec3 out = curve.start[i] - curve.origin;
  const Vec3 in = curve.end[curve.previous[i]] - curve.origin;
  const std::size_t m = face->corner.size();
  if (m == 1) {
    const Vec3 w = face->point[0];
    const Vec3 centre = curve.centre[i] - curve.origin;
    face->point.push_back(2 * in - w);
    face->point.push_back(w + (4 * centre - 2 * (in + out)));
    face->point.push_back(2 * out - w);
    return;
  }
  if (curve.IsSharp(i)) {
    const Vec3 centre = curve.centre[i] - curve.origin;
    AddQuarters(centre, out - centre, in - centre, face);
    return;
  }
  const Vec3 c = 0.5 * (out + in);
  const Vec3 d = 0.5 * (out - in);
  for (std::size_t j = m; j-- > 0;) {
    face->point.push_back(2 * (c + Spread(j, m) * d) - face->point[j]);
  }
}

std::array<Vec3, 4> BoundaryEdgeFace(const HalfEdgeMesh& mesh, const BoundaryCurve& curve,
                                     const Vec3* corners, Index i) {
  const Index h = curve.half_edge[i];
  const Index next = WithWalk(mesh, [&](auto walk) { return walk.Next(h); });
  const Vec3 a = corners[h];
  const Vec3 b = corners[next];
  return {b, a, 2 * (curve.start[i] - curve.origin) - a, 2 * (curve.end[i] - curve.origin) - b};
}

absl::StatusOr<BoundaryCurve> RefineBoundary(const Context& context, const HalfEdgeMesh& mesh,
                                             const BoundaryCurve& curve) {
  BoundaryCurve refined;
  refined.origin = curve.origin;
  const std::size_t size = curve.size();
  refined.half_edge.resize(2 * size);
  refined.next.resize(2 * size);
  refined.previous.resize(2 * size);
  refined.centre.resize(2 * size);
  refined.start.resize(2 * size);
  refined.end.resize(2 * size);
  if (!curve.sharp.empty()) refined.sharp.resize(2 * size);
  LIMN_RETURN_IF_ERROR(ParallelFor(context, size, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index first = static_cast<Index>(2 * i);
      const Index second = first + 1;
      const Index h = curve.half_edge[i];
      // The quads of the half-edge's two corners; see engine/mesh/quad_split.h.
      refined.half_edge[first] = 4 * h;
      refined.half_edge[second] = 4 * WithWalk(mesh, [&](auto walk) { return walk.Next(h); }) + 3;
      refined.next[first] = second;
      refined.previous[second] = first;
      refined.next[second] = 2 * curve.next[i];
      refined.previous[first] = 2 * curve.previous[i] + 1;
      // Chaikin's rule. Each sum reads the same from both ends.
      const Vec3& from = curve.start[i];
      const Vec3& to = curve.end[i];
      refined.centre[first] = curve.centre[i];
      refined.start[first] = 0.5 * (from + curve.centre[i]);
      refined.end[first] = 0.75 * from + 0.25 * to;
      refined.centre[second] = 0.5 * (from + to);
      refined.start[second] = 0.25 * from + 0.75 * to;
      refined.end[second] = 0.5 * (to + curve.centre[curve.next[i]]);
      if (curve.sharp.empty()) continue;
      refined.sharp[first] = curve.sharp[i];
      refined.sharp[second] = 0;
    }
  }));
  return refined;
}

}  // namespace limn
