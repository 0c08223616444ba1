// SPDX-License-Identifier: MIT
#include "engine/constraints/perturb.h"

#include <cmath>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// Below this part of its area a face seen along the prescribed normal counts as collapsed.
constexpr double kCollapsed = 1e-3;

template <class Point>
Vec3 CentroidOf(std::size_t m, const Point& p) {
  const Vec3 origin = p(0);
  Vec3 sum = {0, 0, 0};
  for (std::size_t i = 1; i < m; ++i) sum += p(i) - origin;
  return origin + (1.0 / static_cast<double>(m)) * sum;
}

// The usual case: no normal, no handle, no boundary.
void PerturbFace(absl::Span<const Index> fan, const Vec3& target, absl::Span<Vec3> corners) {
  const auto point = [&](std::size_t i) { return corners[fan[i]]; };
  const Vec3 centroid = CentroidOf(fan.size(), point);
  const Vec3 normal = AverageNormal(fan.size(), centroid, point);
  for (const Index h : fan) {
    // [ZC Eq. 17] as the target plus what remains of the offset in the plane: the rounding of
    // W + (target - centroid) never enters.
    const Vec3 offset = corners[h] - centroid;
    corners[h] = target + (offset - Dot(offset, normal) * normal);
  }
}

// What happens to the offsets of a face's points from its centroid.
class FaceMap {
 public:
  // average: unit normal of the face or zero.
  static FaceMap Onto(const Vec3& average, const SpecialVertex& wish) {
    FaceMap map;
    map.scale_ = wish.handle;
    map.normal_ = wish.has_normal() ? wish.normal : average;
    if (!wish.has_normal() || average == Vec3{0, 0, 0}) return map;
    const double cosine = Dot(average, wish.normal);
    if (std::fabs(cosine) < kCollapsed) map.Turn(average, wish.normal, cosine);
    return map;
  }
  static FaceMap ScaleOnly(double scale) {
    FaceMap map;
    map.scale_ = scale;
    return map;
  }

  Vec3 operator()(Vec3 offset) const {
    if (turns_) {
      // Rodrigues' formula.
      offset = cosine_ * offset + sine_ * Cross(axis_, offset) +
               ((1 - cosine_) * Dot(axis_, offset)) * axis_;
    }
    return scale_ * (offset - Dot(offset, normal_) * normal_);
  }

 private:
  // The shorter way from the face's normal to the line of the prescribed one.
  void Turn(const Vec3& average, const Vec3& normal, double cosine) {
    const bool flip = cosine != 0 ? cosine < 0 : LeadingSign(normal) < 0;
    const Vec3 goal = flip ? -normal : normal;
    axis_ = NormalizedOrZero(Cross(average, goal));
    cosine_ = std::fabs(cosine);
    sine_ = std::sqrt(1 - cosine * cosine);
    turns_ = true;
  }
  // Of n and -n the same one is taken.
  static double LeadingSign(const Vec3& n) { return n.x != 0 ? n.x : n.y != 0 ? n.y : n.z; }

  Vec3 normal_ = {0, 0, 0};
  double scale_ = 1;
  bool turns_ = false;
  Vec3 axis_ = {0, 0, 0};
  double cosine_ = 1;
  double sine_ = 0;
};

class Perturber {
 public:
  Perturber(const PerturbTask& task, absl::Span<Vec3> corners)
      : task_(task), plan_(task.plan != nullptr ? *task.plan : kNoPlan), corners_(corners) {}

  absl::Status Run(const Context& context) {
    const HalfEdgeMesh& mesh = task_.mesh;
    const bool open = task_.boundary != nullptr && !task_.boundary->empty();
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context, mesh.vertex_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) {
            const absl::Span<const Index> fan =
                mesh.fan().subspan(mesh.fan_begin()[v], mesh.valence(v));
            if (open && mesh.twin()[fan[0]] == kNoIndex) continue;
            if (plan_.special(v)) {
              Interior(static_cast<Index>(v), fan);
            } else if (plan_.interpolated(v)) {
              PerturbFace(fan, task_.points[v], corners_);
            }
          }
        }));
    if (!open) return absl::OkStatus();
    return ParallelFor(context, task_.boundary->size(), [&](std::size_t begin, std::size_t end) {
      BoundaryFace face;
      for (std::size_t i = begin; i < end; ++i) Boundary(static_cast<Index>(i), &face);
    });
  }

 private:
  inline static const VertexPlan kNoPlan;

  void Interior(Index v, absl::Span<const Index> fan) {
    const SpecialVertex wish = plan_.At(v);
    const auto point = [&](std::size_t i) { return corners_[fan[i]]; };
    const Vec3 centroid = CentroidOf(fan.size(), point);
    const bool meets = plan_.interpolated(v);
    const FaceMap map = meets ? FaceMap::Onto(AverageNormal(fan.size(), centroid, point), wish)
                              : FaceMap::ScaleOnly(wish.handle);
    const Vec3 target = meets ? task_.points[v] : centroid;
    for (const Index h : fan) corners_[h] = target + map(corners_[h] - centroid);
  }

  void Boundary(Index i, BoundaryFace* face) {
    BoundaryCurve& curve = *task_.boundary;
    const Index v = task_.mesh.vertex()[curve.half_edge[i]];
    const SpecialVertex wish = plan_.At(v);
    const bool meets = plan_.interpolated(v);
    if (!meets && !plan_.special(v)) return;
    GatherBoundaryFace(task_.mesh, curve, corners_.data(), i, face);
    const Vec3 centre = curve.centre[i] - curve.origin;
    const auto point = [&](std::size_t j) { return face->point[j]; };
    const FaceMap map = meets
                            ? FaceMap::Onto(AverageNormal(face->point.size(), centre, point), wish)
                            : FaceMap::ScaleOnly(wish.handle);
    for (const Index h : face->corner) corners_[h] = centre + map(corners_[h] - centre);
    if (!plan_.special(v)) return;
    // The average normal is perpendicular to the curve, which it must not even round.
    const FaceMap along = wish.has_normal() ? map : FaceMap::ScaleOnly(wish.handle);
    Vec3& out = curve.start[i];
    Vec3& in = curve.end[curve.previous[i]];
    out = curve.centre[i] + along(out - curve.centre[i]);
    in = curve.centre[i] + along(in - curve.centre[i]);
  }

  const PerturbTask& task_;
  const VertexPlan& plan_;
  absl::Span<Vec3> corners_;
};

}  // namespace

absl::Status PerturbToInterpolate(const Context& context, const PerturbTask& task,
                                  absl::Span<Vec3> corners) {
  return Perturber(task, corners).Run(context);
}

}  // namespace limn
