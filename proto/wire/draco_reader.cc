// SPDX-License-Identifier: MIT
// See draco_reader.h.
#include "proto/wire/draco_reader.h"

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/decoder_buffer.h>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn::wire {
namespace {

absl::Status Malformed(const std::string& message) {
  return MakeError(absl::StrCat("the Draco mesh ", message),
                   {.reason = Reason::kMalformedEncoding, .field = "mesh"});
}

// Draco allocates an attribute's values when it comes to them; by then all descriptors are known.
bool AttributesAreAllowed(const draco::PointCloud& mesh) {
  if (mesh.num_attributes() > kMaxDracoAttributes) return false;
  for (int i = 0; i < mesh.num_attributes(); ++i) {
    if (mesh.attribute(i)->num_components() > kMaxDracoComponents) return false;
  }
  const draco::PointAttribute* position =
      mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  return position != nullptr && position->num_components() == 3 &&
         position->data_type() != draco::DT_BOOL;
}

template <class Decoder>
class FencedDecoder : public Decoder {
 protected:
  bool DecodeAllAttributes() override {
    return AttributesAreAllowed(*this->point_cloud()) && Decoder::DecodeAllAttributes();
  }
};

absl::Status CheckMesh(const draco::Mesh& mesh, const DracoHeader& header) {
  if (mesh.num_faces() != header.triangles) {
    return Malformed(
        absl::StrCat("holds ", mesh.num_faces(), " triangles, but claims ", header.triangles));
  }
  for (draco::FaceIndex t(0); t < mesh.num_faces(); ++t) {
    for (const draco::PointIndex& p : mesh.face(t)) {
      if (p.value() >= mesh.num_points()) {
        return Malformed(absl::StrCat("names point ", p.value(), " in triangle ", t.value(),
                                      ", but has ", mesh.num_points(), " points"));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<draco::Mesh>> ReadDraco(std::string_view bytes,
                                                       const DracoBounds& bounds) {
  LIMN_ASSIGN_OR_RETURN(const DracoHeader header, ReadDracoHeader(bytes));
  LIMN_RETURN_IF_ERROR(CheckDracoHeader(header, bounds));
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto mesh = std::make_unique<draco::Mesh>();
  const draco::DecoderOptions options;
  draco::Status status;
  if (header.edgebreaker) {
    status = FencedDecoder<draco::MeshEdgebreakerDecoder>().Decode(options, &buffer, mesh.get());
  } else {
    status = FencedDecoder<draco::MeshSequentialDecoder>().Decode(options, &buffer, mesh.get());
  }
  if (!status.ok()) return Malformed(absl::StrCat("does not decode: ", status.error_msg_string()));
  LIMN_RETURN_IF_ERROR(CheckMesh(*mesh, header));
  return mesh;
}

absl::StatusOr<Buffer<Index>> CornerValues(const draco::Mesh& mesh,
                                           const draco::PointAttribute& attribute) {
  const std::size_t stride =
      attribute.num_components() * draco::DataTypeLength(attribute.data_type());
  const bool identity = attribute.is_mapping_identity();
  const std::size_t mapped = identity ? attribute.size() : attribute.indices_map_size();
  if (mapped < mesh.num_points() || attribute.buffer() == nullptr ||
      attribute.byte_stride() != static_cast<std::int64_t>(stride) ||
      attribute.buffer()->data_size() < attribute.size() * stride) {
    return Malformed("has an attribute that is shorter than it should be");
  }
  Buffer<Index> values(3 * std::size_t{mesh.num_faces()});
  Index* out = values.data();
  for (draco::FaceIndex t(0); t < mesh.num_faces(); ++t) {
    for (const draco::PointIndex& p : mesh.face(t)) {
      const Index value = attribute.mapped_index(p).value();
      if (value >= attribute.size()) return Malformed("has a point without a value");
      *out++ = value;
    }
  }
  return values;
}

const draco::PointAttribute* NamedAttribute(const draco::Mesh& mesh, const char* name) {
  const int id = mesh.GetAttributeIdByMetadataEntry("name", name);
  return id < 0 || id >= mesh.num_attributes() ? nullptr : mesh.attribute(id);
}

bool IsKind(const draco::PointAttribute& attribute, draco::DataType type, int components) {
  return attribute.data_type() == type && attribute.num_components() == components;
}

}  // namespace limn::wire
