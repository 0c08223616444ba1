// SPDX-License-Identifier: MIT
#include "engine/constraints/feature_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/refine/average_normal.h"

namespace limn {
namespace {

// Of the bounding box' diagonal: plane enough.
constexpr double kPlanar = 1e-13;
// Sine from which on a plane is another one.
constexpr double kOtherPlane = 1e-3;
// Different planes around a vertex among which those of a further face are looked for.
constexpr std::size_t kPlanesAround = 4;
// Of the shortest edge: the furthest that a vertex is moved.
constexpr double kFurthest = 1.0 / 8;

// Names what made the face a plane one: its entry, or the default.
ErrorDetail DetailOf(const FeatureValues* values, std::size_t face) {
  ErrorDetail detail = {.reason = Reason::kInvalidOption, .field = "constraints.features.faces"};
  if (values == nullptr) return detail;
  const auto entry = std::find_if(values->faces.begin(), values->faces.end(),
                                  [&](const FaceFeature& f) { return f.face == face; });
  if (entry == values->faces.end()) {
    detail.field = "constraints.features.default_face";
    return detail;
  }
  detail.index = static_cast<std::uint64_t>(entry - values->faces.begin());
  absl::StrAppend(&detail.field, "[", *detail.index, "].kind");
  return detail;
}

absl::Status Refuse(ErrorDetail detail, const std::string& message, const char* remedy) {
  detail.remedy = remedy;
  return MakeError(absl::StrCat(detail.field, ": ", message), detail);
}

struct Plane {
  Vec3 normal = {0, 0, 0};
  Vec3 point = {0, 0, 0};

  double Height(const Vec3& p) const { return Dot(normal, p - point); }
};

// Whether they are one plane's, whichever way round; no vector has none.
bool SameDirection(const Vec3& a, const Vec3& b) {
  return Norm(Cross(a, b)) < kOtherPlane * std::fabs(Dot(a, b));
}

// Faces that are joined, each with the least of its set as the set's number.
class FaceSets {
 public:
  explicit FaceSets(std::size_t faces) : parent_(faces) {
    for (std::size_t f = 0; f < faces; ++f) parent_[f] = static_cast<Index>(f);
  }
  Index Find(Index f) {
    while (parent_[f] != f) f = parent_[f] = parent_[parent_[f]];
    return f;
  }
  void Join(Index a, Index b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  Buffer<Index> parent_;
};

class Flattener {
 public:
  Flattener(const HalfEdgeMesh& mesh, const FeatureTable& table, const PlanePoints& given)
      : mesh_(mesh),
        walk_(mesh),
        table_(table),
        points_(given.points),
        values_(given.values),
        scale_(given.scale),
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
    LIMN_RETURN_IF_ERROR(CheckPlanes(context));
    Buffer<Vec3> moved;
    if (height <= planar_) return moved;
    LIMN_RETURN_IF_ERROR(JoinPlanes(context));
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
    const auto vertex = static_cast<std::size_t>(first - failed.begin());
    return Refuse(DetailOf(values_, FaceAround(vertex)),
                  absl::StrCat("the plane faces around vertex ", vertex,
                               " are far from planar, or their planes do not meet near it"),
                  "Make some of them surface faces, or make them planar");
  }

 private:
  // Whether vertices have to be moved into the face's plane; those of triangles are in it wherever
  // they are.
  bool Binds(std::size_t f) const {
    return table_.IsPlane(f) && mesh_.face_begin()[f + 1] - mesh_.face_begin()[f] > 3;
  }

  // The least one that a vertex has to be moved for.
  std::size_t FaceAround(std::size_t v) const {
    std::size_t face = mesh_.face_count();
    for (Index i = mesh_.fan_begin()[v]; i < mesh_.fan_begin()[v + 1]; ++i) {
      const std::size_t f = mesh_.face()[mesh_.fan()[i]];
      if (Binds(f)) face = std::min(face, f);
    }
    return face;
  }

  absl::Status CheckPlanes(const Context& context) const {
    std::size_t flawed = mesh_.face_count();
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context, mesh_.face_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t f = begin; f < end && flawed == mesh_.face_count(); ++f) {
            if (table_.IsPlane(f) && planes_[f].normal == Vec3{0, 0, 0}) flawed = f;
          }
        }));
    if (flawed == mesh_.face_count()) return absl::OkStatus();
    return Refuse(DetailOf(values_, flawed),
                  absl::StrCat("face ", flawed, " has no plane, its corners lie on a line"),
                  "Make it a surface face, or move a corner");
  }

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
    return Binds(f) ? Highest(f) : 0;
  }

  double Highest(std::size_t f) const {
    double highest = 0;
    for (Index h = mesh_.face_begin()[f]; h < mesh_.face_begin()[f + 1]; ++h) {
      highest = std::max(highest, std::fabs(planes_[f].Height(points_[mesh_.vertex()[h]])));
    }
    return highest;
  }

  // Neighbours that are coplanar but for roundings, and not planar for the same reason, get one
  // plane: their own ones are too near to each other to meet in a line that means anything.
  absl::Status JoinPlanes(const Context& context) {
    FaceSets sets(mesh_.face_count());
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context, mesh_.vertex_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) JoinAround(v, &sets);
        }));
    // By the number of a set: the sum of its planes, weighted by area.
    struct Sum {
      Plane plane;
      double weight = 0;
      // It has two faces and more, one of which is not planar.
      bool wide = false;
      bool bent = false;
    };
    Buffer<Sum> sums(mesh_.face_count());
    const auto each = [&](const auto& visit) {
      return ForInOrder(context, mesh_.face_count(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          if (!Binds(f)) continue;
          const Index number = sets.Find(static_cast<Index>(f));
          visit(f, number, sums[number]);
        }
      });
    };
    LIMN_RETURN_IF_ERROR(each([&](std::size_t f, Index number, Sum& sum) {
      const Plane& plane = planes_[f];
      const double weight = AreaOf(f);
      const bool turned = Dot(plane.normal, planes_[number].normal) < 0;
      sum.plane.normal += (turned ? -weight : weight) * plane.normal;
      sum.plane.point += weight * (plane.point - planes_[number].point);
      sum.weight += weight;
      sum.wide = sum.wide || f != number;
      sum.bent = sum.bent || Highest(f) > planar_;
    }));
    LIMN_RETURN_IF_ERROR(each([&](std::size_t f, Index number, Sum& sum) {
      if (f != number || !sum.wide || !sum.bent) return;
      sum.plane = {.normal = NormalizedOrZero(sum.plane.normal),
                   .point = planes_[f].point + (1 / sum.weight) * sum.plane.point};
    }));
    // Not where small turns add up, as around a fine cylinder.
    LIMN_RETURN_IF_ERROR(each([&](std::size_t f, Index /*number*/, Sum& sum) {
      if (!SameDirection(planes_[f].normal, sum.plane.normal)) sum.bent = false;
    }));
    return each([&](std::size_t f, Index /*number*/, const Sum& sum) {
      if (sum.wide && sum.bent) planes_[f] = sum.plane;
    });
  }

  void JoinAround(std::size_t v, FaceSets* sets) const {
    std::array<Index, kPlanesAround> seen;
    std::size_t count = 0;
    for (Index i = mesh_.fan_begin()[v]; i < mesh_.fan_begin()[v + 1]; ++i) {
      const Index f = mesh_.face()[mesh_.fan()[i]];
      if (!Binds(f)) continue;
      const auto end = seen.begin() + static_cast<std::ptrdiff_t>(count);
      const auto same = std::find_if(seen.begin(), end, [&](Index g) {
        return SameDirection(planes_[f].normal, planes_[g].normal);
      });
      if (same != end) {
        sets->Join(f, *same);
      } else if (count < seen.size()) {
        seen[count++] = f;
      }
    }
  }

  // Twice the area, of the square of the scale.
  double AreaOf(std::size_t f) const {
    const Index first = mesh_.face_begin()[f];
    return Norm(AreaAroundOrigin(mesh_.face_begin()[f + 1] - first, [&](std::size_t i) {
                  const Vec3 d = points_[mesh_.vertex()[first + i]] - planes_[f].point;
                  return Vec3{d.x / scale_, d.y / scale_, d.z / scale_};
                }).twice);
  }

  // The shortest way into all planes around a vertex; nothing if there is none that is short. None
  // to go where it is in all of them.
  std::optional<Vec3> Move(std::size_t v) const {
    const absl::Span<const Index> fan = mesh_.fan().subspan(mesh_.fan_begin()[v], mesh_.valence(v));
    const Vec3& at = points_[v];
    if (HeightAround(fan, at) <= planar_) return Vec3{0, 0, 0};
    Vec3 by = {0, 0, 0};
    // Orthonormal directions that have been used.
    std::array<Vec3, 3> used;
    for (std::size_t count = 0; count < used.size(); ++count) {
      Vec3 widest = {0, 0, 0};
      double width = kOtherPlane;
      double height = 0;
      for (const Index h : fan) {
        if (!Binds(mesh_.face()[h])) continue;
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
    // Planes that count as one may differ by as much as is planar.
    if (HeightAround(fan, at + by) > 2 * planar_) return std::nullopt;
    if (Norm(by) > std::max(kFurthest * ShortestEdge(fan, at), planar_)) return std::nullopt;
    return by;
  }

  double HeightAround(absl::Span<const Index> fan, const Vec3& at) const {
    double highest = 0;
    for (const Index h : fan) {
      const Index f = mesh_.face()[h];
      if (Binds(f)) highest = std::max(highest, std::fabs(planes_[f].Height(at)));
    }
    return highest;
  }

  // Edges without length bound nothing: they have none to keep.
  double ShortestEdge(absl::Span<const Index> fan, const Vec3& at) const {
    double shortest = std::numeric_limits<double>::infinity();
    for (const Index h : fan) {
      for (const Index other : {walk_.Next(h), walk_.Prev(h)}) {
        const double length = Norm(points_[mesh_.vertex()[other]] - at);
        if (length > planar_) shortest = std::min(shortest, length);
      }
    }
    return std::isfinite(shortest) ? shortest : 0;
  }

  const HalfEdgeMesh& mesh_;
  const PolygonWalk walk_;
  const FeatureTable& table_;
  const absl::Span<const Vec3> points_;
  const FeatureValues* const values_;
  const double scale_;
  const double planar_;
  // By face.
  Buffer<Plane> planes_;
};

}  // namespace

absl::StatusOr<Buffer<Vec3>> FlattenPlaneFaces(const Context& context, const HalfEdgeMesh& mesh,
                                               const FeatureTable& table,
                                               const PlanePoints& given) {
  return Flattener(mesh, table, given).Run(context);
}

}  // namespace limn
