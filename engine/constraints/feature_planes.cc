// SPDX-License-Identifier: MIT
#include "engine/constraints/feature_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/perturb.h"

namespace limn {
namespace {

// Of the bounding box' diagonal: plane enough.
constexpr double kPlanar = 1e-13;
// Sine from which on a plane is another one.
constexpr double kOtherPlane = 1e-3;
// Of the shortest edge: the furthest that a vertex is moved.
constexpr double kFurthest = 1.0 / 8;

absl::Status Refuse(std::size_t index, const std::string& message, const char* remedy) {
  return MakeError(absl::StrCat("constraints.features: ", message),
                   {.reason = Reason::kInvalidOption,
                    .field = "constraints.features",
                    .index = index,
                    .remedy = remedy});
}

struct Plane {
  Vec3 normal = {0, 0, 0};
  Vec3 point = {0, 0, 0};

  double Height(const Vec3& p) const { return Dot(normal, p - point); }
};

class Flattener {
 public:
  Flattener(const HalfEdgeMesh& mesh, const FeatureTable& table, const PlanePoints& given)
      : mesh_(mesh),
        walk_(mesh),
        table_(table),
        points_(given.points),
        planar_(kPlanar * given.scale) {}

  absl::StatusOr<Buffer<Vec3>> Run(const Context& context) {
    planes_.resize(mesh_.face_count());
    double height = 0;
    LIMN_RETURN_IF_ERROR(ParallelMax(
        context, mesh_.face_count(), 0,
        [&](std::size_t begin, std::size_t end) {
          double highest = 0;
          for (std::size_t f = begin; f < end; ++f) {
            if (table_.IsPlane(f)) highest = std::max(highest, FindPlane(f));
          }
          return highest;
        },
        &height));
    for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
      if (!table_.IsPlane(f) || planes_[f].normal != Vec3{0, 0, 0}) continue;
      return Refuse(f, absl::StrCat("face ", f, " has no plane, its corners lie on a line"),
                    "Make it a surface face, or move a corner");
    }
    Buffer<Vec3> moved;
    if (height <= planar_) return moved;
    moved.assign(points_.begin(), points_.end());
    Buffer<std::uint8_t> failed(points_.size());
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context, points_.size(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) {
            const std::optional<Vec3> by = Move(v);
            failed[v] = by.has_value() ? 0 : 1;
            if (by.has_value()) moved[v] += *by;
          }
        }));
    const auto first = std::find(failed.begin(), failed.end(), 1);
    if (first == failed.end()) return moved;
    const auto v = static_cast<std::size_t>(first - failed.begin());
    return Refuse(v,
                  absl::StrCat("the plane faces around vertex ", v,
                               " are far from planar, or their planes do not meet near it"),
                  "Make some of them surface faces, or make them planar");
  }

 private:
  // The largest height of a corner over the plane.
  double FindPlane(std::size_t f) {
    const Index first = mesh_.face_begin()[f];
    const std::size_t m = mesh_.face_begin()[f + 1] - first;
    const auto point = [&](std::size_t i) { return points_[mesh_.vertex()[first + i]]; };
    Vec3 sum = {0, 0, 0};
    for (std::size_t i = 1; i < m; ++i) sum += point(i) - point(0);
    Plane& plane = planes_[f];
    plane.point = point(0) + (1.0 / static_cast<double>(m)) * sum;
    plane.normal = AverageNormal(m, plane.point, point);
    double highest = 0;
    for (std::size_t i = 0; i < m; ++i) {
      highest = std::max(highest, std::fabs(plane.Height(point(i))));
    }
    return highest;
  }

  // The shortest way into all planes around a vertex; nothing if there is none that is short.
  std::optional<Vec3> Move(std::size_t v) const {
    const absl::Span<const Index> fan = mesh_.fan().subspan(mesh_.fan_begin()[v], mesh_.valence(v));
    const Vec3& at = points_[v];
    Vec3 by = {0, 0, 0};
    // Orthonormal directions that have been used.
    std::array<Vec3, 3> used;
    for (std::size_t count = 0; count < used.size(); ++count) {
      Vec3 widest = {0, 0, 0};
      double width = kOtherPlane;
      double height = 0;
      for (const Index h : fan) {
        if (!table_.IsPlane(mesh_.face()[h])) continue;
        const Plane& plane = planes_[mesh_.face()[h]];
        Vec3 rest = plane.normal;
        for (std::size_t i = 0; i < count; ++i) rest -= Dot(rest, used[i]) * used[i];
        if (Norm(rest) <= width) continue;
        width = Norm(rest);
        widest = rest;
        height = plane.Height(at + by);
      }
      if (widest == Vec3{0, 0, 0}) break;
      used[count] = (1 / width) * widest;
      by -= (height / width) * used[count];
    }
    double shortest = std::numeric_limits<double>::infinity();
    for (const Index h : fan) {
      const Index f = mesh_.face()[h];
      if (table_.IsPlane(f) && std::fabs(planes_[f].Height(at + by)) > planar_) return std::nullopt;
      for (const Index other : {walk_.Next(h), walk_.Prev(h)}) {
        shortest = std::min(shortest, Norm(points_[mesh_.vertex()[other]] - at));
      }
    }
    if (Norm(by) > std::max(kFurthest * shortest, planar_)) return std::nullopt;
    return by;
  }

  const HalfEdgeMesh& mesh_;
  const PolygonWalk walk_;
  const FeatureTable& table_;
  const absl::Span<const Vec3> points_;
  const double planar_;
  // By face.
  Buffer<Plane> planes_;
};

// Gives each run of corners around a vertex its number.
class Cutter {
 public:
  Cutter(const HalfEdgeMesh& mesh, absl::Span<const std::uint8_t> plane)
      : mesh_(mesh), plane_(plane) {}

  absl::StatusOr<HalfEdgeMesh> Run(const Context& context) {
    PolygonMesh cut;
    cut.face_begin.assign(mesh_.face_begin().begin(), mesh_.face_begin().end());
    cut.corner_vertex.assign(mesh_.vertex().begin(), mesh_.vertex().end());
    std::size_t vertices = mesh_.vertex_count();
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context, mesh_.vertex_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) {
            CutVertex(static_cast<Index>(v), &cut.corner_vertex, &vertices);
          }
        }));
    // Nobody looks at them but at their number.
    cut.positions.resize(vertices);
    return HalfEdgeMesh::Build(context, cut);
  }

 private:
  bool IsCut(Index h) const {
    const Index twin = mesh_.twin()[h];
    return plane_[mesh_.face()[h]] != 0 || (twin != kNoIndex && plane_[mesh_.face()[twin]] != 0);
  }

  void CutVertex(Index v, Buffer<Index>* corner_vertex, std::size_t* vertices) const {
    const absl::Span<const Index> fan = mesh_.fan().subspan(mesh_.fan_begin()[v], mesh_.valence(v));
    // A run begins with the half-edge that leaves along a cut, or along the boundary.
    std::size_t first = 0;
    if (!mesh_.IsBoundary(v)) {
      while (first < fan.size() && !IsCut(fan[first])) ++first;
      if (first == fan.size()) return;
    }
    Index number = v;
    for (std::size_t i = 0; i < fan.size(); ++i) {
      const Index h = fan[(first + i) % fan.size()];
      if (i > 0 && IsCut(h)) {
        number = static_cast<Index>((*vertices)++);
      }
      (*corner_vertex)[h] = number;
    }
  }

  const HalfEdgeMesh& mesh_;
  const absl::Span<const std::uint8_t> plane_;
};

}  // namespace

absl::StatusOr<Buffer<Vec3>> FlattenPlaneFaces(const Context& context, const HalfEdgeMesh& mesh,
                                               const FeatureTable& table,
                                               const PlanePoints& given) {
  return Flattener(mesh, table, given).Run(context);
}

absl::StatusOr<HalfEdgeMesh> CutAlongPlanes(const Context& context, const HalfEdgeMesh& mesh,
                                            absl::Span<const std::uint8_t> plane) {
  return Cutter(mesh, plane).Run(context);
}

}  // namespace limn
