// SPDX-License-Identifier: MIT
#include "engine/constraints/features.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/constraints/feature_cut.h"
#include "engine/constraints/feature_face.h"
#include "engine/constraints/feature_planes.h"
#include "engine/constraints/perturb.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/mesh/validate.h"
#include "engine/refine/boundary_curve.h"

namespace limn {
namespace {

absl::Status Refuse(std::string_view list, std::size_t index, const std::string& message) {
  std::string field = absl::StrCat("constraints.", std::string(list), "[", index, "]");
  std::string text = absl::StrCat(field, ": ", message);
  return MakeError(text,
                   {.reason = Reason::kInvalidOption,
                    .field = std::move(field),
                    .index = index,
                    .remedy = "Leave it out, or make the plane faces around it surface faces"});
}

// The feet on the line from a to b of two points that belong to its ends; see the header.
std::array<Vec3, 2> FeetOn(const Vec3& a, const Vec3& b, const Vec3& of_a, const Vec3& of_b) {
  const Vec3 along = b - a;
  const double size = MaxAbs(along);
  if (!(size > 0)) return {a, b};
  // Squares of tiny and of huge lengths are none.
  const auto scaled = [&](const Vec3& d) { return Vec3{d.x / size, d.y / size, d.z / size}; };
  const Vec3 unit = scaled(along);
  const auto share = [&](const Vec3& p) {
    return std::clamp(Dot(scaled(p - a), unit) / Dot(unit, unit), 0.0, 1.0);
  };
  double from = share(of_a);
  double to = share(of_b);
  if (from > to) from = to = 0.5 * (from + to);
  const auto at = [&](double t) { return t <= 0.5 ? a + t * along : b - (1 - t) * along; };
  return {at(from), at(to)};
}

}  // namespace

// One call of Make.
class FeatureSurface::Maker {
 public:
  Maker(const Context& context, const FeatureTask& task, const FeatureTable& table,
        FeatureSurface* feature)
      : context_(context),
        task_(task),
        table_(table),
        given_(feature->given()),
        mesh_(feature->surface_.mesh),
        curve_(feature->surface_.boundary),
        corners_(feature->surface_.corners) {}

  absl::Status Run() {
    LIMN_RETURN_IF_ERROR(FindPoints());
    LIMN_RETURN_IF_ERROR(MarkVertices());
    LIMN_RETURN_IF_ERROR(CheckConstraints());
    corners_.resize(given_.half_edge_count());
    LIMN_RETURN_IF_ERROR(MakeSurfaceFaces());
    LIMN_RETURN_IF_ERROR(PlaceCurve());
    if (!table_.plane.empty()) LIMN_RETURN_IF_ERROR(MakePlaneFaces());
    return Perturb();
  }

 private:
  // What is said of a vertex of T^0.
  static constexpr std::uint8_t kInterpolated = 1;
  static constexpr std::uint8_t kOfPlane = 2;
  static constexpr std::uint8_t kCorner = 4;

  // Relative to the origin, and with planar plane faces.
  absl::Status FindPoints() {
    const std::size_t n = given_.vertex_count();
    points_.resize(n);
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, n, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) points_[v] = task_.points[v] - task_.origin;
    }));
    if (table_.plane.empty()) return absl::OkStatus();
    BoundingBox box;
    LIMN_RETURN_IF_ERROR(ValidatePositions(context_, points_, &box));
    const double scale = box.diagonal() > 0 ? box.diagonal() : 1;
    const std::optional<FeatureValues>& values = task_.constraints.features;
    LIMN_ASSIGN_OR_RETURN(Buffer<Vec3> flat,
                          FlattenPlaneFaces(context_, given_, table_,
                                            {.points = points_,
                                             .scale = scale,
                                             .values = values.has_value() ? &*values : nullptr}));
    if (flat.empty()) return absl::OkStatus();
    moved_ = true;
    points_ = std::move(flat);
    return absl::OkStatus();
  }

  absl::Status MarkVertices() {
    marks_.assign(given_.vertex_count(), 0);
    if (task_.constraints.interpolate.has_value()) {
      const std::vector<Index>& vertices = *task_.constraints.interpolate;
      LIMN_RETURN_IF_ERROR(
          ForInOrder(context_, vertices.size(), [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) marks_[vertices[i]] = kInterpolated;
          }));
    }
    if (table_.plane.empty()) return absl::OkStatus();
    return ParallelFor(context_, marks_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        std::size_t planes = 0;
        for (Index i = given_.fan_begin()[v]; i < given_.fan_begin()[v + 1]; ++i) {
          if (table_.IsPlane(given_.face()[given_.fan()[i]])) ++planes;
        }
        if (planes == 0) continue;
        marks_[v] |= kOfPlane;
        if (planes > 1 || given_.IsBoundary(v) || (marks_[v] & kInterpolated) != 0) {
          marks_[v] |= kCorner;
        }
      }
    });
  }

  absl::Status CheckConstraints() const {
    const Constraints& constraints = task_.constraints;
    const auto of_plane = [&](Index v) { return (marks_[v] & kOfPlane) != 0; };
    LIMN_RETURN_IF_ERROR(
        CheckList("normals", constraints.normals.size(), "the vertex belongs to a plane face",
                  [&](std::size_t i) { return !of_plane(constraints.normals[i].vertex); }));
    LIMN_RETURN_IF_ERROR(CheckList(
        "shape_handles", constraints.shape_handles.size(), "the vertex belongs to a plane face",
        [&](std::size_t i) { return !of_plane(constraints.shape_handles[i].vertex); }));
    if (!moved_ || !constraints.interpolate.has_value()) return context_.Check();
    const std::vector<Index>& vertices = *constraints.interpolate;
    return CheckList("interpolate.vertices", vertices.size(),
                     "the vertex has to move, since a plane face around it is not planar",
                     [&](std::size_t i) {
                       const Index v = vertices[i];
                       return points_[v] == task_.points[v] - task_.origin;
                     });
  }

  // Refuses the first entry that is not well.
  template <class Well>
  absl::Status CheckList(std::string_view list, std::size_t size, const char* message,
                         const Well& well) const {
    std::size_t flawed = size;
    LIMN_RETURN_IF_ERROR(ForInOrder(context_, size, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && flawed == size; ++i) {
        if (!well(i)) flawed = i;
      }
    }));
    return flawed == size ? absl::OkStatus() : Refuse(list, flawed, message);
  }

  absl::Status MakeSurfaceFaces() {
    constexpr std::size_t kGrain = 512;
    return ParallelFor(
        context_, given_.face_count(), kGrain, [&](std::size_t begin, std::size_t end) {
          FeatureImages images;
          std::vector<Vec3> point;
          for (std::size_t f = begin; f < end; ++f) {
            if (table_.IsPlane(f)) continue;
            const Index first = given_.face_begin()[f];
            const Index last = given_.face_begin()[f + 1];
            point.clear();
            for (Index h = first; h < last; ++h) point.push_back(points_[given_.vertex()[h]]);
            images.Make({.point = point,
                         .edge = absl::MakeConstSpan(table_.edge).subspan(first, last - first),
                         .vertex = absl::MakeConstSpan(table_.vertex).subspan(first, last - first)},
                        absl::MakeSpan(corners_).subspan(first, last - first));
          }
        });
  }

  // Everything as at any boundary; then what plane faces change of it.
  absl::Status PlaceCurve() {
    const std::size_t size = curve_.size();
    curve_.origin = task_.origin;
    Buffer<Vec3> control(size);
    Buffer<std::uint8_t> interpolated(size);
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, size, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Index v = given_.vertex()[curve_.half_edge[i]];
        control[i] = moved_ ? points_[v] + task_.origin : task_.points[v];
        interpolated[i] = marks_[v] == kInterpolated ? 1 : 0;
      }
    }));
    double residual = 0;
    LIMN_RETURN_IF_ERROR(PlaceBoundary(
        context_,
        {.mesh = mesh_, .points = control, .control = control, .interpolated = interpolated},
        &curve_, &residual));
    if (table_.plane.empty()) {
      curve_.sharp.clear();
      return absl::OkStatus();
    }
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, size, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) PlaceFeet(i);
    }));
    curve_.sharp.resize(size);
    return ParallelFor(context_, size, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint8_t mark = marks_[given_.vertex()[curve_.half_edge[i]]];
        curve_.sharp[i] = (mark & kCorner) != 0 ? 1 : 0;
        if ((mark & kOfPlane) == 0) continue;
        curve_.centre[i] = (mark & kCorner) != 0
                               ? control[i]
                               : 0.5 * (curve_.start[i] + curve_.end[curve_.previous[i]]);
      }
    });
  }

  void PlaceFeet(std::size_t i) {
    const PolygonWalk walk(given_);
    const Index h = curve_.half_edge[i];
    const Index twin = given_.twin()[h];
    if (twin == kNoIndex) return;
    const bool plane = table_.IsPlane(given_.face()[h]);
    if (plane && table_.IsPlane(given_.face()[twin])) return;
    // Both sides ask the surface face.
    const Index of = plane ? twin : h;
    const Index next = walk.Next(of);
    const std::array<Vec3, 2> feet = FeetOn(
        points_[given_.vertex()[of]], points_[given_.vertex()[next]], corners_[of], corners_[next]);
    curve_.start[i] = feet[plane ? 1 : 0] + task_.origin;
    curve_.end[i] = feet[plane ? 0 : 1] + task_.origin;
  }

  absl::Status MakePlaneFaces() {
    return ParallelFor(context_, given_.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        if (!table_.IsPlane(f)) continue;
        const Index first = given_.face_begin()[f];
        const Index last = given_.face_begin()[f + 1];
        for (Index h = first; h < last; ++h) {
          corners_[h] = curve_.centre[curve_.Find(h)] - task_.origin;
        }
        Vec3 sum = {0, 0, 0};
        for (Index h = first + 1; h < last; ++h) sum += corners_[h] - corners_[first];
        const Vec3 mean = corners_[first] + (1.0 / static_cast<double>(last - first)) * sum;
        for (Index h = first; h < last; ++h) corners_[h] = 0.5 * (corners_[h] + mean);
      }
    });
  }

  // Corners of plane faces are met already.
  absl::Status Perturb() {
    const Constraints& constraints = task_.constraints;
    Constraints left;
    left.interpolate.emplace();
    left.normals = constraints.normals;
    left.shape_handles = constraints.shape_handles;
    if (constraints.interpolate.has_value()) {
      for (const Index v : *constraints.interpolate) {
        if ((marks_[v] & kOfPlane) == 0) left.interpolate->push_back(v);
      }
    }
    if (left.interpolate->empty() && left.shape_handles.empty()) return context_.Check();
    const VertexPlan plan(left, mesh_.vertex_count());
    return PerturbToInterpolate(
        context_, {.mesh = mesh_, .points = points_, .plan = &plan, .boundary = &curve_},
        absl::MakeSpan(corners_));
  }

  const Context& context_;
  const FeatureTask& task_;
  const FeatureTable& table_;
  // T^0, and the same cut along planes.
  const HalfEdgeMesh& given_;
  const HalfEdgeMesh& mesh_;
  BoundaryCurve& curve_;
  Buffer<Vec3>& corners_;
  Buffer<Vec3> points_;
  bool moved_ = false;
  Buffer<std::uint8_t> marks_;
};

absl::StatusOr<FeatureSurface> FeatureSurface::Create(const Context& context, HalfEdgeMesh mesh) {
  FeatureSurface feature(std::move(mesh));
  LIMN_ASSIGN_OR_RETURN(feature.surface_.boundary, FindBoundary(context, feature.surface_.mesh));
  return feature;
}

absl::Status FeatureSurface::FollowPlanes(const Context& context, const FeatureTable& table) {
  if (table.plane == plane_) return absl::OkStatus();
  // Kept only when all of it is there, so that an error leaves what was.
  std::optional<HalfEdgeMesh> cut;
  if (!table.plane.empty()) {
    LIMN_ASSIGN_OR_RETURN(cut, CutAlongPlanes(context, given(), table.plane));
  }
  LIMN_ASSIGN_OR_RETURN(BoundaryCurve boundary,
                        FindBoundary(context, cut.has_value() ? *cut : given()));
  Buffer<std::uint8_t> plane = table.plane;
  ++cuts_;
  if (given_.has_value()) {
    surface_.mesh = *std::move(given_);
    given_.reset();
  }
  if (cut.has_value()) given_ = std::exchange(surface_.mesh, *std::move(cut));
  plane_ = std::move(plane);
  surface_.boundary = std::move(boundary);
  return absl::OkStatus();
}

absl::Status FeatureSurface::Make(const Context& context, const FeatureTask& task) {
  static const FeatureValues kDefaults;
  const std::optional<FeatureValues>& values = task.constraints.features;
  LIMN_ASSIGN_OR_RETURN(
      const FeatureTable table,
      MakeFeatureTable(context, given(), values.has_value() ? *values : kDefaults));
  LIMN_RETURN_IF_ERROR(FollowPlanes(context, table));
  return Maker(context, task, table, this).Run();
}

}  // namespace limn
