// SPDX-License-Identifier: MIT
#include "server/constraints_from_proto.h"

#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine/base/error.h"

namespace limn {
namespace {

absl::Status CheckBuilt(const v1::Constraints& constraints) {
  struct Kind {
    bool used;
    absl::string_view field;
    absl::string_view feature;
  };
  const Kind kinds[] = {
      {constraints.has_features(), "constraints.features", "feature values are"},
  };
  for (const Kind& kind : kinds) {
    if (!kind.used) continue;
    return MakeError(absl::StrCat(kind.field, ": ", kind.feature, " not implemented yet"),
                     {.reason = Reason::kUnimplemented,
                      .field = std::string(kind.field),
                      .remedy = "Leave it out"});
  }
  return absl::OkStatus();
}

absl::Status CheckCount(absl::string_view field, int count, std::uint64_t vertex_count) {
  if (vertex_count == 0 || static_cast<std::uint64_t>(count) <= vertex_count) {
    return absl::OkStatus();
  }
  return MakeError(
      absl::StrCat(field, ": it has ", count, " entries for ", vertex_count, " vertices"),
      {.reason = Reason::kInvalidOption,
       .field = std::string(field),
       .remedy = "Name each vertex at most once"});
}

absl::Status CheckCounts(const v1::Constraints& constraints, std::uint64_t vertex_count) {
  LIMN_RETURN_IF_ERROR(CheckCount("constraints.interpolate.vertices",
                                  constraints.interpolate().vertices_size(), vertex_count));
  LIMN_RETURN_IF_ERROR(CheckCount("constraints.normals", constraints.normals_size(), vertex_count));
  return CheckCount("constraints.shape_handles", constraints.shape_handles_size(), vertex_count);
}

absl::Status ReadNormals(const v1::Constraints& constraints, std::vector<NormalConstraint>* out) {
  out->reserve(static_cast<std::size_t>(constraints.normals_size()));
  for (const v1::NormalConstraint& entry : constraints.normals()) {
    if (!entry.has_normal()) {
      std::string field = absl::StrCat("constraints.normals[", out->size(), "].normal");
      std::string message = absl::StrCat(field, ": it is missing");
      return MakeError(message, {.reason = Reason::kInvalidOption,
                                 .field = std::move(field),
                                 .index = out->size(),
                                 .remedy = "Give a direction of any length above zero"});
    }
    const v1::Vector3& normal = entry.normal();
    out->push_back({.vertex = entry.vertex(), .normal = {normal.x(), normal.y(), normal.z()}});
  }
  return absl::OkStatus();
}

std::optional<Vec3> ReadVector(bool given, const v1::Vector3& v) {
  if (!given) return std::nullopt;
  return Vec3{v.x(), v.y(), v.z()};
}

void ReadSurfacePoints(const v1::Constraints& constraints, Constraints* out) {
  out->surface_points.reserve(static_cast<std::size_t>(constraints.surface_points_size()));
  for (const v1::SurfaceConstraint& given : constraints.surface_points()) {
    SurfaceConstraint& entry = out->surface_points.emplace_back();
    if (given.has_vertex()) entry.vertex = given.vertex();
    if (given.has_parameter()) {
      const v1::FaceParameter& place = given.parameter();
      entry.parameter = {
          .face = place.face(), .corner = place.corner(), .u = place.u(), .v = place.v()};
    }
    entry.point = ReadVector(given.has_point(), given.point());
    entry.normal = ReadVector(given.has_normal(), given.normal());
    entry.derivative_u = ReadVector(given.has_derivative_u(), given.derivative_u());
    entry.derivative_v = ReadVector(given.has_derivative_v(), given.derivative_v());
    entry.region.assign(given.region().begin(), given.region().end());
  }
}

void ReadSharp(const v1::Constraints& constraints, Constraints* out) {
  out->creases.reserve(static_cast<std::size_t>(constraints.creases_size()));
  for (const v1::Crease& crease : constraints.creases()) {
    CreaseConstraint& entry = out->creases.emplace_back();
    entry.vertices.assign(crease.vertices().begin(), crease.vertices().end());
    entry.sharpness.assign(crease.sharpness().begin(), crease.sharpness().end());
  }
  out->corners.reserve(static_cast<std::size_t>(constraints.corners_size()));
  for (const v1::SharpVertex& corner : constraints.corners()) {
    out->corners.push_back(
        {.vertex = corner.vertex(), .sharpness = static_cast<float>(corner.sharpness())});
  }
  out->holes.assign(constraints.holes().begin(), constraints.holes().end());
}

}  // namespace

absl::StatusOr<Constraints> ConstraintsFromProto(const v1::Constraints& constraints,
                                                 std::uint64_t vertex_count) {
  LIMN_RETURN_IF_ERROR(CheckBuilt(constraints));
  LIMN_RETURN_IF_ERROR(CheckCounts(constraints, vertex_count));
  Constraints out;
  if (constraints.has_interpolate()) {
    const auto& vertices = constraints.interpolate().vertices();
    out.interpolate.emplace(vertices.begin(), vertices.end());
  }
  LIMN_RETURN_IF_ERROR(ReadNormals(constraints, &out.normals));
  out.shape_handles.reserve(static_cast<std::size_t>(constraints.shape_handles_size()));
  for (const v1::ShapeHandle& handle : constraints.shape_handles()) {
    out.shape_handles.push_back({.vertex = handle.vertex(), .value = handle.value()});
  }
  ReadSurfacePoints(constraints, &out);
  ReadSharp(constraints, &out);
  return out;
}

std::uint64_t ConstraintBytes(const Constraints& constraints) {
  const std::size_t subset =
      constraints.interpolate.has_value() ? constraints.interpolate->size() : 0;
  std::uint64_t creases = constraints.creases.size() * sizeof(CreaseConstraint);
  for (const CreaseConstraint& crease : constraints.creases) {
    creases += crease.vertices.size() * sizeof(Index) + crease.sharpness.size() * sizeof(float);
  }
  std::uint64_t points = constraints.surface_points.size() * sizeof(SurfaceConstraint);
  for (const SurfaceConstraint& entry : constraints.surface_points) {
    points += entry.region.size() * sizeof(Index);
  }
  return points + subset * sizeof(Index) + constraints.normals.size() * sizeof(NormalConstraint) +
         constraints.shape_handles.size() * sizeof(ShapeHandle) + creases +
         constraints.corners.size() * sizeof(CornerConstraint) +
         constraints.holes.size() * sizeof(Index);
}

}  // namespace limn
