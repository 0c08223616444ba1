// SPDX-License-Identifier: MIT
// See draco_decoder.h.
#include "proto/wire/draco_decoder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/draco_reader.h"
#include "proto/wire/triangulation.h"

namespace limn::wire {
namespace {

absl::Status Malformed(const std::string& message) {
  return MakeError(absl::StrCat("the Draco mesh ", message),
                   {.reason = Reason::kMalformedEncoding, .field = "mesh"});
}

template <class T>
T ValueAt(const draco::PointAttribute& attribute, Index value) {
  T out;
  std::memcpy(&out, attribute.GetAddress(draco::AttributeValueIndex(value)), sizeof(T));
  return out;
}

// The value as doubles; attributes of three components.
Vec3 VectorAt(const draco::PointAttribute& attribute, Index value) {
  if (attribute.data_type() == draco::DT_FLOAT64) return ValueAt<Vec3>(attribute, value);
  if (attribute.data_type() == draco::DT_FLOAT32) {
    const auto v = ValueAt<std::array<float, 3>>(attribute, value);
    return {v[0], v[1], v[2]};
  }
  std::array<double, 3> v = {0, 0, 0};
  attribute.ConvertValue<double, 3>(draco::AttributeValueIndex(value), v.data());
  return {v[0], v[1], v[2]};
}

// Vertices as corners name them: by original ids if there are any, by the positions' values
// otherwise.
struct Numbering {
  Buffer<Index> corner_vertex;
  Buffer<Index> original_ids;
  std::size_t vertices = 0;
};

// Ids 0 ... n - 1, each used, as in a whole mesh; false for anything else.
bool IsDense(const Buffer<Index>& ids, std::size_t values, std::size_t* count) {
  const Index largest = *std::max_element(ids.begin(), ids.end());
  if (largest >= values) return false;
  std::vector<bool> used(std::size_t{largest} + 1);
  for (const Index id : ids) used[id] = true;
  *count = used.size();
  return std::find(used.begin(), used.end(), false) == used.end();
}

absl::StatusOr<Numbering> NumberById(const draco::Mesh& mesh,
                                     const draco::PointAttribute& id_attribute) {
  // Two uint16, the low half first, read as one little-endian number.
  if (!IsKind(id_attribute, draco::DT_UINT32, 1) && !IsKind(id_attribute, draco::DT_UINT16, 2)) {
    return Malformed("has original ids that are neither uint32 nor two uint16");
  }
  Numbering numbering;
  LIMN_ASSIGN_OR_RETURN(numbering.corner_vertex, CornerValues(mesh, id_attribute));
  for (Index& corner : numbering.corner_vertex) {
    corner = ValueAt<std::uint32_t>(id_attribute, corner);
    if (corner == kNoIndex) return Malformed("has a vertex without an original id");
  }
  if (IsDense(numbering.corner_vertex, id_attribute.size(), &numbering.vertices)) {
    return numbering;
  }
  Buffer<Index>& ids = numbering.original_ids;
  ids = numbering.corner_vertex;
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  for (Index& corner : numbering.corner_vertex) {
    corner = static_cast<Index>(std::lower_bound(ids.begin(), ids.end(), corner) - ids.begin());
  }
  numbering.vertices = ids.size();
  return numbering;
}

// One value per vertex, from the first corner that names it.
Buffer<Vec3> GatherVectors(const Numbering& numbering, const draco::PointAttribute& attribute,
                           const Buffer<Index>& corner_values) {
  Buffer<Vec3> vectors(numbering.vertices, Vec3{0, 0, 0});
  std::vector<bool> set(numbering.vertices);
  for (std::size_t c = 0; c < corner_values.size(); ++c) {
    const Index v = numbering.corner_vertex[c];
    if (set[v]) continue;
    set[v] = true;
    vectors[v] = VectorAt(attribute, corner_values[c]);
  }
  return vectors;
}

// Without ids every value is a vertex, also one that no face uses.
Buffer<Vec3> AllVectors(const draco::PointAttribute& attribute) {
  Buffer<Vec3> vectors(attribute.size());
  for (std::size_t v = 0; v < vectors.size(); ++v) {
    vectors[v] = VectorAt(attribute, static_cast<Index>(v));
  }
  return vectors;
}

absl::StatusOr<std::vector<Index>> ReadArities(const draco::Mesh& mesh) {
  std::vector<Index> arities;
  const draco::GeometryMetadata* metadata = mesh.GetMetadata();
  std::vector<std::uint8_t> bytes;
  if (metadata == nullptr || !metadata->GetEntryBinary(kAritiesEntry, &bytes)) return arities;
  if (bytes.size() % sizeof(Index) != 0) return Malformed("has a broken list of arities");
  arities.resize(bytes.size() / sizeof(Index));
  std::memcpy(arities.data(), bytes.data(), bytes.size());
  return arities;
}

absl::StatusOr<Buffer<std::uint8_t>> ReadAddedEdges(const draco::Mesh& mesh) {
  Buffer<std::uint8_t> added;
  const draco::PointAttribute* attribute = NamedAttribute(mesh, kAddedEdgesName);
  if (attribute == nullptr) return added;
  if (!IsKind(*attribute, draco::DT_UINT8, 1)) return Malformed("has added_edges beside uint8");
  LIMN_ASSIGN_OR_RETURN(const Buffer<Index> values, CornerValues(mesh, *attribute));
  added.resize(values.size());
  for (std::size_t c = 0; c < values.size(); ++c) {
    added[c] = ValueAt<std::uint8_t>(*attribute, values[c]) != 0;
  }
  return added;
}

absl::StatusOr<Polygons> RebuildPolygons(const Context& context, const draco::Mesh& mesh,
                                         Buffer<Index> triangles) {
  LIMN_ASSIGN_OR_RETURN(const std::vector<Index> arities, ReadArities(mesh));
  LIMN_ASSIGN_OR_RETURN(const Buffer<std::uint8_t> added, ReadAddedEdges(mesh));
  LIMN_RETURN_IF_ERROR(context.Check());
  if (!arities.empty() && !added.empty()) {
    return Malformed("has both limn.arities and added_edges");
  }
  if (!arities.empty()) return PolygonsFromFans(triangles, arities);
  if (!added.empty()) return JoinMarked(context, triangles, added);
  Polygons polygons;
  polygons.face_begin.resize(triangles.size() / 3 + 1);
  for (std::size_t f = 0; f < polygons.face_begin.size(); ++f) {
    polygons.face_begin[f] = static_cast<Index>(3 * f);
  }
  polygons.corner_vertex = std::move(triangles);
  return polygons;
}

absl::Status FillVertices(const Context& context, const draco::Mesh& mesh,
                          const Numbering& numbering, bool want_normals, DracoOutput* out) {
  const draco::PointAttribute& position =
      *mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  LIMN_ASSIGN_OR_RETURN(const Buffer<Index> values, CornerValues(mesh, position));
  LIMN_RETURN_IF_ERROR(context.Check());
  // Normals come with tiles only, which name their vertices.
  const bool by_id = NamedAttribute(mesh, kOriginalIdName) != nullptr;
  out->mesh.positions = by_id ? GatherVectors(numbering, position, values) : AllVectors(position);
  const draco::PointAttribute* normal = mesh.GetNamedAttribute(draco::GeometryAttribute::NORMAL);
  if (!want_normals || !by_id || normal == nullptr || normal->num_components() != 3) {
    return absl::OkStatus();
  }
  LIMN_ASSIGN_OR_RETURN(const Buffer<Index> normal_values, CornerValues(mesh, *normal));
  out->normals = GatherVectors(numbering, *normal, normal_values);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<DracoOutput> DecodeDraco(const Context& context, std::string_view bytes,
                                        const DracoBounds& bounds) {
  LIMN_ASSIGN_OR_RETURN(const std::unique_ptr<draco::Mesh> mesh, ReadDraco(context, bytes, bounds));
  const draco::PointAttribute& position =
      *mesh->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  const draco::PointAttribute* ids = NamedAttribute(*mesh, kOriginalIdName);
  Numbering numbering;
  if (ids != nullptr) {
    LIMN_ASSIGN_OR_RETURN(numbering, NumberById(*mesh, *ids));
  } else {
    LIMN_ASSIGN_OR_RETURN(numbering.corner_vertex, CornerValues(*mesh, position));
    numbering.vertices = position.size();
  }
  if (numbering.vertices > bounds.max_vertices) {
    return MakeError(absl::StrCat("the Draco mesh has ", numbering.vertices, " vertices; ",
                                  bounds.max_vertices, " are allowed"),
                     {.reason = Reason::kLimitExceeded,
                      .field = "mesh.vertices",
                      .remedy = "Send a smaller mesh, or check the counts of the header",
                      .limit = "max-vertices"});
  }
  DracoOutput out;
  LIMN_RETURN_IF_ERROR(context.Check());
  LIMN_RETURN_IF_ERROR(FillVertices(context, *mesh, numbering, bounds.want_normals, &out));
  LIMN_RETURN_IF_ERROR(context.Check());
  LIMN_ASSIGN_OR_RETURN(Polygons polygons,
                        RebuildPolygons(context, *mesh, std::move(numbering.corner_vertex)));
  out.mesh.face_begin = std::move(polygons.face_begin);
  out.mesh.corner_vertex = std::move(polygons.corner_vertex);
  out.original_ids = std::move(numbering.original_ids);
  return out;
}

}  // namespace limn::wire
