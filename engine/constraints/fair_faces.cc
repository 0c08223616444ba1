// SPDX-License-Identifier: MIT
#include "engine/constraints/fair_faces.h"

#include <algorithm>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/perturb.h"
#include "engine/refine/boundary_curve.h"

namespace limn {
namespace {

// The dot product's part of |e|^2, where the squares of very small edges vanish: none.
double Extent(const Vec3& offset, const Vec3& edge) {
  const double square = Dot(edge, edge);
  return square > 0 ? Dot(offset, edge) / square : 0;
}

template <class Point>
Vec3 MeanOf(std::size_t m, const Point& p) {
  const Vec3 origin = p(0);
  Vec3 sum = {0, 0, 0};
  for (std::size_t i = 1; i < m; ++i) sum += p(i) - origin;
  return origin + (1.0 / static_cast<double>(m)) * sum;
}

}  // namespace

absl::StatusOr<FairFaces> FairFaces::Make(const Context& context, const DooSabinSurface& surface,
                                          const VertexPlan& plan) {
  FairFaces faces(surface, plan);
  LIMN_RETURN_IF_ERROR(faces.Place(context, surface.corners));
  return faces;
}

absl::Status FairFaces::Place(const Context& context, absl::Span<const Vec3> corners) {
  centre_.resize(mesh_.vertex_count());
  freedom_.resize(mesh_.vertex_count());
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh_.vertex_count(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          if (AtBoundary(v)) continue;
          const absl::Span<const Index> fan = Fan(v);
          centre_[v] = MeanOf(fan.size(), [&](std::size_t i) { return corners[fan[i]]; });
          freedom_[v] = FreedomOf(v);
        }
      }));
  return ParallelFor(context, boundary_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index v = mesh_.vertex()[boundary_.half_edge[i]];
      centre_[v] = boundary_.centre[i] - boundary_.origin;
      freedom_[v] = FreedomOf(v);
    }
  });
}

FaceFreedom FairFaces::FreedomOf(std::size_t v) const {
  const SpecialVertex wish = plan_.At(static_cast<Index>(v));
  if (wish.handle != 1) return FaceFreedom::kFixed;
  if (wish.has_normal()) return FaceFreedom::kGiven;
  if (!plan_.interpolated(v)) return FaceFreedom::kLoose;
  return FaceFreedom::kPlane;
}

void FairFaces::Project(std::size_t v, absl::Span<Vec3> change) const {
  const absl::Span<const Index> fan = Fan(v);
  const FaceFreedom freedom = freedom_[v];
  if (freedom == FaceFreedom::kFixed) {
    for (const Index h : fan) change[h] = {0, 0, 0};
    return;
  }
  if (!AtBoundary(v)) {
    // Ghosts mirror every change at a boundary: the sum is zero there anyway.
    const Vec3 mean = MeanOf(fan.size(), [&](std::size_t i) { return change[fan[i]]; });
    for (const Index h : fan) change[h] -= mean;
  }
  if (freedom != FaceFreedom::kGiven) return;
  const Vec3 normal = plan_.At(static_cast<Index>(v)).normal;
  for (const Index h : fan) change[h] -= Dot(change[h], normal) * normal;
}

template <class Offset>
double FairFaces::Handle(std::size_t v, double extent, const Offset& offset) const {
  const PolygonWalk walk(mesh_);
  const absl::Span<const Index> fan = Fan(v);
  double largest = 0;
  for (std::size_t i = 0; i < fan.size(); ++i) {
    const Vec3& leaving = centre_[mesh_.vertex()[walk.Next(fan[i])]];
    const Vec3& entering = centre_[mesh_.vertex()[walk.Prev(fan[i])]];
    largest = std::max(largest, Extent(offset(i), leaving - centre_[v]));
    largest = std::max(largest, Extent(offset(i), entering - centre_[v]));
  }
  return largest > extent ? extent / largest : 1;
}

void FairFaces::HandleInterior(std::size_t v, double extent, absl::Span<Vec3> corners) const {
  const absl::Span<const Index> fan = Fan(v);
  const double handle =
      Handle(v, extent, [&](std::size_t i) { return corners[fan[i]] - centre_[v]; });
  if (handle == 1) return;
  for (const Index h : fan) corners[h] = centre_[v] + handle * (corners[h] - centre_[v]);
}

void FairFaces::HandleBoundary(Index i, double extent, absl::Span<Vec3> corners,
                               BoundaryFace* face) const {
  GatherBoundaryFace(mesh_, boundary_, corners.data(), i, face);
  const std::size_t m = face->corner.size();
  if (m == 1) return;
  // Half the way from the ghost.
  const auto offset = [&](std::size_t j) {
    return 0.5 * (face->point[j] - face->point[2 * m - 1 - j]);
  };
  const double handle = Handle(mesh_.vertex()[boundary_.half_edge[i]], extent, offset);
  if (handle == 1) return;
  for (std::size_t j = 0; j < m; ++j) corners[face->corner[j]] -= (1 - handle) * offset(j);
}

absl::Status FairFaces::ApplyHandles(const Context& context, double extent,
                                     absl::Span<Vec3> corners) const {
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh_.vertex_count(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          if (freedom_[v] == FaceFreedom::kFixed || AtBoundary(v)) continue;
          HandleInterior(v, extent, corners);
        }
      }));
  return ParallelFor(context, boundary_.size(), [&](std::size_t begin, std::size_t end) {
    BoundaryFace face;
    for (std::size_t i = begin; i < end; ++i) {
      if (freedom_[mesh_.vertex()[boundary_.half_edge[i]]] == FaceFreedom::kFixed) continue;
      HandleBoundary(static_cast<Index>(i), extent, corners, &face);
    }
  });
}

void FairFaces::SettleInterior(std::size_t v, absl::Span<Vec3> corners) const {
  const absl::Span<const Index> fan = Fan(v);
  const auto point = [&](std::size_t i) { return corners[fan[i]]; };
  const Vec3 mean = MeanOf(fan.size(), point);
  Vec3 normal = {0, 0, 0};
  if (freedom_[v] == FaceFreedom::kPlane) normal = AverageNormal(fan.size(), mean, point);
  if (freedom_[v] == FaceFreedom::kGiven) normal = plan_.At(static_cast<Index>(v)).normal;
  for (const Index h : fan) {
    const Vec3 offset = corners[h] - mean;
    corners[h] = centre_[v] + (offset - Dot(offset, normal) * normal);
  }
}

void FairFaces::SettleBoundary(Index i, absl::Span<Vec3> corners, BoundaryFace* face) const {
  const Index v = mesh_.vertex()[boundary_.half_edge[i]];
  Vec3 normal = {0, 0, 0};
  if (freedom_[v] == FaceFreedom::kLoose) return;
  if (freedom_[v] == FaceFreedom::kGiven) {
    normal = plan_.At(v).normal;
  } else {
    GatherBoundaryFace(mesh_, boundary_, corners.data(), i, face);
    normal = AverageNormal(face->point.size(), centre_[v],
                           [&](std::size_t j) { return face->point[j]; });
  }
  for (const Index h : Fan(v)) {
    const Vec3 offset = corners[h] - centre_[v];
    corners[h] = centre_[v] + (offset - Dot(offset, normal) * normal);
  }
}

absl::Status FairFaces::Settle(const Context& context, absl::Span<Vec3> corners) const {
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, mesh_.vertex_count(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          if (freedom_[v] != FaceFreedom::kFixed && !AtBoundary(v)) SettleInterior(v, corners);
        }
      }));
  return ParallelFor(context, boundary_.size(), [&](std::size_t begin, std::size_t end) {
    BoundaryFace face;
    for (std::size_t i = begin; i < end; ++i) {
      if (freedom_[mesh_.vertex()[boundary_.half_edge[i]]] == FaceFreedom::kFixed) continue;
      SettleBoundary(static_cast<Index>(i), corners, &face);
    }
  });
}

}  // namespace limn
