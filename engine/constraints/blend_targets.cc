// SPDX-License-Identifier: MIT
#include "engine/constraints/blend_targets.h"

#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/constraints/vertex_plan.h"

namespace limn {
namespace {

constexpr std::size_t kEntriesPerCheck = 1024;
// What counts as perpendicular and as parallel, in radians.
constexpr double kAngle = 2e-11;

absl::Status Refuse(Reason reason, const BlendTarget& target, std::string_view member,
                    const std::string& message, std::string_view remedy) {
  std::string field = absl::StrCat(target.path(), std::string(member));
  std::string text = absl::StrCat(field, ": ", message);
  return MakeError(text, {.reason = reason,
                          .field = std::move(field),
                          .index = target.index,
                          .remedy = std::string(remedy)});
}

absl::Status OutOfRange(const BlendTarget& target, std::string_view member, std::string_view what,
                        std::uint64_t value, std::uint64_t count) {
  return Refuse(Reason::kIndexOutOfRange, target, member,
                absl::StrCat("there is no ", std::string(what), " ", value, ", there are ", count),
                "They are counted from 0");
}

absl::Status Invalid(const BlendTarget& target, std::string_view member, const std::string& message,
                     std::string_view remedy) {
  return Refuse(Reason::kInvalidOption, target, member, message, remedy);
}

class TargetList {
 public:
  TargetList(const BlendMesh& mesh, const Constraints& constraints)
      : mesh_(mesh.mesh),
        kind_(mesh.kind),
        hole_(mesh.hole),
        constraints_(constraints),
        points_(mesh.points) {}

  absl::StatusOr<std::vector<BlendTarget>> Make(const Context& context) {
    const std::size_t normals = constraints_.normals.size();
    const std::size_t count = normals + constraints_.surface_points.size();
    if (count == 0) return std::move(targets_);
    targets_.reserve(count);
    taken_.assign(mesh_.vertex_count(), false);
    plan_ = VertexPlan(constraints_, mesh_.vertex_count());
    for (std::size_t i = 0; i < count; ++i) {
      if (i % kEntriesPerCheck == 0) LIMN_RETURN_IF_ERROR(context.Check());
      LIMN_RETURN_IF_ERROR(i < normals ? AddNormal(i) : AddSurfaceConstraint(i - normals));
    }
    return std::move(targets_);
  }

 private:
  absl::Status AddNormal(std::size_t i) {
    const NormalConstraint& given = constraints_.normals[i];
    BlendTarget target = {.of_normals = true, .index = i};
    LIMN_RETURN_IF_ERROR(PlaceAtVertex(given.vertex, &target));
    target.normal = NormalizedOrZero(given.normal);
    targets_.push_back(std::move(target));
    return absl::OkStatus();
  }

  absl::Status AddSurfaceConstraint(std::size_t i) {
    const SurfaceConstraint& given = constraints_.surface_points[i];
    BlendTarget target = {.index = i, .region = given.region};
    if (given.vertex.has_value() == given.parameter.has_value()) {
      return Invalid(target, "", given.vertex.has_value() ? "it has two places" : "it has no place",
                     "Give either a vertex or a parameter");
    }
    LIMN_RETURN_IF_ERROR(given.vertex.has_value() ? PlaceAtVertex(*given.vertex, &target)
                                                  : PlaceAtParameter(*given.parameter, &target));
    LIMN_RETURN_IF_ERROR(TakeAims(given, &target));
    LIMN_RETURN_IF_ERROR(CheckRegion(target));
    targets_.push_back(std::move(target));
    return absl::OkStatus();
  }

  absl::Status PlaceAtVertex(Index vertex, BlendTarget* target) {
    if (vertex >= mesh_.vertex_count()) {
      return OutOfRange(*target, ".vertex", "vertex", vertex, mesh_.vertex_count());
    }
    LIMN_RETURN_IF_ERROR(TakeVertex(vertex, ".vertex", target));
    const Index h = mesh_.vertex_half_edge()[vertex];
    const Index face = mesh_.face()[h];
    target->vertex = vertex;
    target->place = {.face = face, .corner = h - mesh_.face_begin()[face]};
    return absl::OkStatus();
  }

  absl::Status TakeVertex(Index vertex, std::string_view member, BlendTarget* target) {
    if (taken_[vertex]) {
      return Invalid(*target, member,
                     absl::StrCat("vertex ", vertex, " is named before, by ", Owner(vertex)),
                     "Ask for everything at a vertex in one constraint");
    }
    taken_[vertex] = true;
    target->on_vertex = vertex;
    return absl::OkStatus();
  }

  // The vertex that a valid parameter is at, or kNoIndex.
  Index VertexAt(const SurfaceParameter& p) const {
    const Index first = mesh_.face_begin()[p.face];
    const Index arity = mesh_.face_begin()[p.face + 1] - first;
    if (p.u == 0 && p.v == 0) return mesh_.vertex()[first + p.corner];
    if (kind_ == RingKind::kQuads) return kNoIndex;
    if (p.u == 1) return mesh_.vertex()[first + (p.corner + 1) % arity];
    return p.v == 1 ? mesh_.vertex()[first + (p.corner + 2) % arity] : kNoIndex;
  }

  std::string Owner(Index vertex) const {
    for (const BlendTarget& other : targets_) {
      if (other.on_vertex == vertex) return other.path();
    }
    return "another constraint";
  }

  absl::Status PlaceAtParameter(const SurfaceParameter& p, BlendTarget* target) {
    if (p.face >= mesh_.face_count()) {
      return OutOfRange(*target, ".parameter.face", "face", p.face, mesh_.face_count());
    }
    if (!hole_.empty() && hole_[p.face] != 0) {
      return Invalid(*target, ".parameter.face",
                     absl::StrCat("face ", p.face, " is no part of the surface"),
                     "Name a face that is no hole");
    }
    const Index arity = mesh_.face_begin()[p.face + 1] - mesh_.face_begin()[p.face];
    if (p.corner >= arity) {
      return OutOfRange(*target, ".parameter.corner", absl::StrCat("corner of face ", p.face, ":"),
                        p.corner, arity);
    }
    // Written so that NaN is refused.
    const auto check = [&](std::string_view member, double t) -> absl::Status {
      if (t >= 0 && t <= 1) return absl::OkStatus();
      return Invalid(*target, member, absl::StrCat("it is ", t), "It must be from 0 to 1");
    };
    LIMN_RETURN_IF_ERROR(check(".parameter.u", p.u));
    LIMN_RETURN_IF_ERROR(check(".parameter.v", p.v));
    if (kind_ == RingKind::kTriangles && p.u + p.v > 1) {
      return Invalid(*target, ".parameter.v", absl::StrCat("it is ", p.v, " where u is ", p.u),
                     "It must be at most 1 - u in a triangle");
    }
    target->place = p;
    const Index vertex = VertexAt(p);
    return vertex == kNoIndex ? absl::OkStatus() : TakeVertex(vertex, ".parameter", target);
  }

  absl::Status TakeAims(const SurfaceConstraint& given, BlendTarget* target) const {
    if (!given.point && !given.normal && !given.derivative_u && !given.derivative_v) {
      return Invalid(*target, "", "it asks for nothing",
                     "Give a point, a normal or a derivative, or leave the constraint out");
    }
    const auto check = [&](std::string_view member, const std::optional<Vec3>& value,
                           bool direction) -> absl::Status {
      if (!value.has_value()) return absl::OkStatus();
      if (!IsFinite(*value)) {
        return Invalid(*target, member, "it is not finite", "Give three finite numbers");
      }
      if (direction && !(MaxAbs(*value) > 0)) {
        return Invalid(*target, member, "it is zero", "Give a direction");
      }
      return absl::OkStatus();
    };
    LIMN_RETURN_IF_ERROR(check(".point", given.point, false));
    LIMN_RETURN_IF_ERROR(check(".normal", given.normal, true));
    LIMN_RETURN_IF_ERROR(check(".derivative_u", given.derivative_u, true));
    LIMN_RETURN_IF_ERROR(check(".derivative_v", given.derivative_v, true));
    target->point = given.point;
    if (given.normal.has_value()) target->normal = NormalizedOrZero(*given.normal);
    target->du = given.derivative_u;
    target->dv = given.derivative_v;
    LIMN_RETURN_IF_ERROR(CheckDerivatives(*target));
    return CheckPoint(*target);
  }

  absl::Status CheckDerivatives(const BlendTarget& target) const {
    if (target.vertex.has_value() && (target.du || target.dv)) {
      return Invalid(target, target.du ? ".derivative_u" : ".derivative_v",
                     "a vertex has no directions u and v",
                     "Give the parameter of a corner at the vertex, with u and v 0, instead");
    }
    const Vec3 u = NormalizedOrZero(target.du.value_or(Vec3{}));
    const Vec3 v = NormalizedOrZero(target.dv.value_or(Vec3{}));
    if (target.du && target.dv && Norm(Cross(u, v)) < kAngle) {
      return Invalid(target, ".derivative_v", "it is parallel to derivative_u",
                     "Give two derivatives that span the tangent plane");
    }
    if (!target.normal.has_value()) return absl::OkStatus();
    if (std::fabs(Dot(u, *target.normal)) > kAngle || std::fabs(Dot(v, *target.normal)) > kAngle) {
      return Invalid(target, ".normal", "it is not perpendicular to the derivatives",
                     "Leave the normal or the derivatives out");
    }
    return absl::OkStatus();
  }

  absl::Status CheckPoint(const BlendTarget& target) const {
    if (!target.on_vertex || !target.point || !plan_.interpolated(*target.on_vertex)) {
      return absl::OkStatus();
    }
    if (*target.point == points_[*target.on_vertex]) return absl::OkStatus();
    return Invalid(target, ".point",
                   absl::StrCat("vertex ", *target.on_vertex, " is to be met at another point"),
                   "Move the vertex, or leave it out of constraints.interpolate");
  }

  absl::Status CheckRegion(const BlendTarget& target) const {
    const std::uint64_t faces = kind_ == RingKind::kQuads
                                    ? std::uint64_t{4} * mesh_.half_edge_count()
                                    : std::uint64_t{16} * mesh_.face_count();
    for (std::size_t i = 0; i < target.region.size(); ++i) {
      if (target.region[i] >= faces) {
        return OutOfRange(target, absl::StrCat(".region[", i, "]"),
                          "face of the twice refined mesh", target.region[i], faces);
      }
    }
    return absl::OkStatus();
  }

  const HalfEdgeMesh& mesh_;
  const RingKind kind_;
  const absl::Span<const std::uint8_t> hole_;
  const Constraints& constraints_;
  const absl::Span<const Vec3> points_;
  VertexPlan plan_;
  std::vector<bool> taken_;
  std::vector<BlendTarget> targets_;
};

}  // namespace

std::string BlendTarget::path() const {
  return absl::StrCat("constraints.", of_normals ? "normals" : "surface_points", "[", index, "]");
}

absl::StatusOr<std::vector<BlendTarget>> BlendTargets(const Context& context, const BlendMesh& mesh,
                                                      const Constraints& constraints) {
  return TargetList(mesh, constraints).Make(context);
}

}  // namespace limn
