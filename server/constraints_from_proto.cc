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

absl::Status UnknownKind(const std::string& field, int value) {
  return MakeError(absl::StrCat(field, ": ", value, " is no value of this enumeration"),
                   {.reason = Reason::kInvalidOption,
                    .field = field,
                    .remedy = "Use one of the values in the contract"});
}

FaceKind KindOf(v1::FeatureValues::FaceKind kind) {
  return kind == v1::FeatureValues::FACE_KIND_PLANE ? FaceKind::kPlane : FaceKind::kSurface;
}

// The value of entry `index`, which has no default: an entry without one would be sharp by mistake.
template <class Entry>
absl::Status ReadValue(absl::string_view list, std::size_t index, const Entry& entry, double* out) {
  *out = entry.value();
  if (entry.has_value()) return absl::OkStatus();
  std::string field = absl::StrCat("constraints.features.", list, "[", index, "].value");
  std::string message = absl::StrCat(field, ": it is missing");
  return MakeError(message, {.reason = Reason::kInvalidOption,
                             .field = std::move(field),
                             .index = index,
                             .remedy = "Give a number from 0 to 1"});
}

// Their number is bounded by that of the message's bytes; whether they are in range is for
// MakeFeatureTable to say.
absl::Status ReadFeatures(const v1::FeatureValues& features, FeatureValues* out) {
  if (!v1::FeatureValues::FaceKind_IsValid(features.default_face())) {
    return UnknownKind("constraints.features.default_face", features.default_face());
  }
  out->default_face = KindOf(features.default_face());
  if (features.has_default_edge()) out->default_edge = features.default_edge();
  if (features.has_default_vertex()) out->default_vertex = features.default_vertex();
  out->faces.reserve(static_cast<std::size_t>(features.faces_size()));
  for (const v1::FeatureValues::Face& face : features.faces()) {
    if (!v1::FeatureValues::FaceKind_IsValid(face.kind())) {
      return UnknownKind(absl::StrCat("constraints.features.faces[", out->faces.size(), "].kind"),
                         face.kind());
    }
    out->faces.push_back({.face = face.face(), .kind = KindOf(face.kind())});
  }
  out->edges.reserve(static_cast<std::size_t>(features.edges_size()));
  for (const v1::FeatureValues::Edge& edge : features.edges()) {
    EdgeFeature& entry = out->edges.emplace_back();
    entry = {.from = edge.from(), .to = edge.to()};
    LIMN_RETURN_IF_ERROR(ReadValue("edges", out->edges.size() - 1, edge, &entry.value));
    if (edge.has_face()) entry.face = edge.face();
  }
  out->vertices.reserve(static_cast<std::size_t>(features.vertices_size()));
  for (const v1::FeatureValues::Vertex& vertex : features.vertices()) {
    VertexFeature& entry = out->vertices.emplace_back();
    entry = {.vertex = vertex.vertex()};
    LIMN_RETURN_IF_ERROR(ReadValue("vertices", out->vertices.size() - 1, vertex, &entry.value));
    if (vertex.has_face()) entry.face = vertex.face();
  }
  return absl::OkStatus();
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
  if (constraints.has_features()) {
    LIMN_RETURN_IF_ERROR(ReadFeatures(constraints.features(), &out.features.emplace()));
  }
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
  std::uint64_t features = 0;
  if (constraints.features.has_value()) {
    features = constraints.features->faces.size() * sizeof(FaceFeature) +
               constraints.features->edges.size() * sizeof(EdgeFeature) +
               constraints.features->vertices.size() * sizeof(VertexFeature);
  }
  return points + subset * sizeof(Index) + features +
         constraints.normals.size() * sizeof(NormalConstraint) +
         constraints.shape_handles.size() * sizeof(ShapeHandle) + creases +
         constraints.corners.size() * sizeof(CornerConstraint) +
         constraints.holes.size() * sizeof(Index);
}

}  // namespace limn
