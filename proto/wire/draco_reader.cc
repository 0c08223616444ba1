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
  int value_bytes = 0;
  for (int i = 0; i < mesh.num_attributes(); ++i) {
    const int components = mesh.attribute(i)->num_components();
    if (components > kMaxDracoComponents) return false;
    value_bytes += components * (draco::DataTypeLength(mesh.attribute(i)->data_type()) + 4);
  }
  if (value_bytes > kMaxDracoValueBytes) return false;
  const draco::PointAttribute* position =
      mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  return position != nullptr && position->num_components() == 3 &&
         position->data_type() != draco::DT_BOOL;
}

// Sequential: one decoder holds all attributes, and predicts from the value before only.
class FencedSequentialDecoder : public draco::MeshSequentialDecoder {
 public:
  explicit FencedSequentialDecoder(const Context& context) : context_(context) {}

 protected:
  bool DecodeAllAttributes() override {
    return !context_.stop_requested() && AttributesAreAllowed(*point_cloud()) &&
           MeshSequentialDecoder::DecodeAllAttributes();
  }

 private:
  const Context& context_;
};

// Edgebreaker: attributes come one by one, each with a decoder and a prediction of its own choice.
// The predictions for texture coordinates read a count from the bytes and believe it: four bytes
// cost seconds and hundreds of megabytes. So what is not wanted is not decoded where that can be
// avoided, and these predictions are not let in.
class FencedEdgebreakerDecoder : public draco::MeshEdgebreakerDecoder {
 public:
  FencedEdgebreakerDecoder(const Context& context, bool want_normals)
      : context_(context), want_normals_(want_normals) {}

 protected:
  bool DecodeAllAttributes() override {
    if (!AttributesAreAllowed(*point_cloud())) return false;
    int wanted = num_attributes_decoders() - 1;
    while (wanted >= 0 && !IsWanted(wanted)) --wanted;
    for (int i = 0; i <= wanted; ++i) {
      if (context_.stop_requested() || !MayDecode(i)) return false;
      // The accessor is const for Draco's own reasons; the object is not.
      auto* decoder = const_cast<draco::AttributesDecoderInterface*>(attributes_decoder(i));
      if (!decoder->DecodeAttributes(buffer())) return false;
    }
    return true;
  }

 private:
  const draco::PointAttribute* FirstAttribute(int decoder) {
    return point_cloud()->attribute(attributes_decoder(decoder)->GetAttributeId(0));
  }

  bool IsPosition(const draco::PointAttribute* attribute) {
    return attribute == mesh()->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  }

  bool IsWanted(int decoder) {
    const draco::PointAttribute* attribute = FirstAttribute(decoder);
    return IsPosition(attribute) || attribute == NamedAttribute(*mesh(), kOriginalIdName) ||
           attribute == NamedAttribute(*mesh(), kAddedEdgesName) ||
           (want_normals_ && attribute->attribute_type() == draco::GeometryAttribute::NORMAL);
  }

  // The prediction stands in the next two bytes, method and transform, unless the values are raw
  // floats. Positions cannot be predicted from positions; normals are wanted from servers only.
  bool MayDecode(int decoder) {
    if (attributes_decoder(decoder)->GetNumAttributes() != 1) return false;
    const draco::PointAttribute* attribute = FirstAttribute(decoder);
    if (IsPosition(attribute) ||
        (want_normals_ && attribute->attribute_type() == draco::GeometryAttribute::NORMAL)) {
      return true;
    }
    if (buffer()->remaining_size() < 2) return false;
    const int method = buffer()->data_head()[0];
    return buffer()->data_head()[1] != draco::PREDICTION_TRANSFORM_WRAP ||
           (method != draco::MESH_PREDICTION_TEX_COORDS_PORTABLE &&
            method != draco::MESH_PREDICTION_TEX_COORDS_DEPRECATED);
  }

  const Context& context_;
  const bool want_normals_;
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

absl::StatusOr<std::unique_ptr<draco::Mesh>> ReadDraco(const Context& context,
                                                       std::string_view bytes,
                                                       const DracoBounds& bounds) {
  LIMN_ASSIGN_OR_RETURN(const DracoHeader header, ReadDracoHeader(bytes));
  LIMN_RETURN_IF_ERROR(CheckDracoHeader(header, bounds));
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto mesh = std::make_unique<draco::Mesh>();
  const draco::DecoderOptions options;
  draco::Status status;
  if (header.edgebreaker) {
    status =
        FencedEdgebreakerDecoder(context, bounds.want_normals).Decode(options, &buffer, mesh.get());
  } else {
    status = FencedSequentialDecoder(context).Decode(options, &buffer, mesh.get());
  }
  LIMN_RETURN_IF_ERROR(context.Check());
  if (!status.ok()) {
    return MakeError(
        absl::StrCat("the Draco mesh does not decode: ", status.error_msg_string()),
        {.reason = Reason::kMalformedEncoding,
         .field = "mesh",
         .remedy = "If another program reads it, encode positions only, or with speed 5 or less"});
  }
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
