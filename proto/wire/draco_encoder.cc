// SPDX-License-Identifier: MIT
// See draco_encoder.h.
#include "proto/wire/draco_encoder.h"

#include <draco/compression/config/encoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_encoder.h>
#include <draco/compression/mesh/mesh_sequential_encoder.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/draco_header.h"

namespace limn::wire {
namespace {

static_assert(std::endian::native == std::endian::little);

// Draco's corners and values are int32 in places.
constexpr std::size_t kMaxDracoSize = std::size_t{1} << 31;

// Speed 5 is the fastest that keeps attributes with their own connectivity; it uses edgebreaker's
// standard traversal.
constexpr int kSpeed = 5;

absl::Status CheckSizes(const DracoInput& input) {
  const std::size_t size = std::max(input.positions.size(), 3 * input.faces.triangle_count());
  if (size < kMaxDracoSize) return absl::OkStatus();
  return MakeError(
      "the mesh is larger than Draco can say (2^31 vertices or triangle corners)",
      {.reason = Reason::kLimitExceeded, .field = "faces", .remedy = "Use MESH_ENCODING_PACKED"});
}

absl::Status IsolatedVertex(std::size_t vertex) {
  return MakeError(absl::StrCat("vertex ", vertex, " is used by no face; Draco cannot keep it"),
                   {.reason = Reason::kIsolatedVertex,
                    .field = "vertices",
                    .index = vertex,
                    .remedy = "Remove the vertex, or use MESH_ENCODING_PACKED"});
}

// A draco::Mesh in the making.
class MeshBuilder {
 public:
  // corners: three per triangle, numbers of points.
  MeshBuilder(std::size_t points, absl::Span<const Index> corners) {
    mesh_.set_num_points(static_cast<std::uint32_t>(points));
    mesh_.SetNumFaces(corners.size() / 3);
    for (std::uint32_t t = 0; t < corners.size() / 3; ++t) {
      draco::Mesh::Face face;
      for (int i = 0; i < 3; ++i) face[i] = draco::PointIndex(corners[3 * t + i]);
      mesh_.SetFace(draco::FaceIndex(t), face);
    }
  }

  // Adds an attribute with the values' bytes; returns its number.
  int Add(draco::GeometryAttribute::Type type, int components, draco::DataType data_type,
          absl::Span<const char> values) {
    const std::size_t stride = components * draco::DataTypeLength(data_type);
    auto attribute = std::make_unique<draco::PointAttribute>();
    attribute->Init(type, static_cast<std::int8_t>(components), data_type, false,
                    values.size() / stride);
    attribute->buffer()->Write(0, values.data(), values.size());
    attribute->SetIdentityMapping();
    return mesh_.AddAttribute(std::move(attribute));
  }

  template <class T>
  int Add(draco::GeometryAttribute::Type type, int components, draco::DataType data_type,
          const std::vector<T>& values) {
    return Add(type, components, data_type,
               absl::MakeConstSpan(reinterpret_cast<const char*>(values.data()),
                                   values.size() * sizeof(T)));
  }

  void Name(int attribute, const std::string& name) {
    auto metadata = std::make_unique<draco::AttributeMetadata>();
    metadata->AddEntryString("name", name);
    mesh_.AddAttributeMetadata(attribute, std::move(metadata));
  }

  // value_of_point: the attribute's value for each point.
  template <class ValueOfPoint>
  void Map(int attribute, const ValueOfPoint& value_of_point) {
    draco::PointAttribute* values = mesh_.attribute(attribute);
    values->SetExplicitMapping(mesh_.num_points());
    for (draco::PointIndex p(0); p < mesh_.num_points(); ++p) {
      values->SetPointMapEntry(p, draco::AttributeValueIndex(value_of_point(p.value())));
    }
  }

  void AddArities(const PolygonView& faces) {
    std::vector<std::uint8_t> bytes(faces.face_count() * sizeof(Index));
    for (std::size_t f = 0; f < faces.face_count(); ++f) {
      const Index arity = static_cast<Index>(faces.arity(f));
      std::memcpy(bytes.data() + f * sizeof(Index), &arity, sizeof(Index));
    }
    // The names of attributes stand in the same metadata.
    if (mesh_.GetMetadata() == nullptr) {
      mesh_.AddMetadata(std::make_unique<draco::GeometryMetadata>());
    }
    mesh_.metadata()->AddEntryBinary(kAritiesEntry, bytes);
  }

  const draco::Mesh& mesh() const { return mesh_; }

 private:
  draco::Mesh mesh_;
};

std::vector<float> Floats(absl::Span<const Vec3> points) {
  std::vector<float> floats;
  floats.reserve(3 * points.size());
  for (const Vec3& p : points) {
    for (const double x : {p.x, p.y, p.z}) floats.push_back(static_cast<float>(x));
  }
  return floats;
}

// Adds the attribute of original ids; returns its number.
int AddIds(const DracoInput& input, MeshBuilder* builder) {
  int attribute = 0;
  if (input.original_ids.empty()) {
    std::vector<std::uint32_t> ids(input.positions.size());
    std::iota(ids.begin(), ids.end(), 0U);
    attribute = builder->Add(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT32, ids);
  } else {
    // Little-endian: the halves lie in memory as they should.
    attribute =
        builder->Add(draco::GeometryAttribute::GENERIC, 2, draco::DT_UINT16,
                     absl::MakeConstSpan(reinterpret_cast<const char*>(input.original_ids.data()),
                                         sizeof(Index) * input.original_ids.size()));
  }
  builder->Name(attribute, kOriginalIdName);
  return attribute;
}

// Stops between connectivity and attributes. Encoder: one of Draco's.
template <class Encoder>
class StoppableEncoder : public Encoder {
 public:
  explicit StoppableEncoder(const Context& context) : context_(context) {}

 protected:
  bool EncodeAllAttributes() override {
    return !context_.stop_requested() && Encoder::EncodeAllAttributes();
  }

 private:
  const Context& context_;
};

// What draco::ExpertEncoder does.
template <class Encoder>
absl::StatusOr<std::string> Encode(const Context& context, const draco::Mesh& mesh,
                                   draco::EncoderOptions options) {
  LIMN_RETURN_IF_ERROR(context.Check());
  options.SetSpeed(kSpeed, kSpeed);
  StoppableEncoder<Encoder> encoder(context);
  encoder.SetMesh(mesh);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.Encode(options, &buffer);
  LIMN_RETURN_IF_ERROR(context.Check());
  if (!status.ok()) {
    return MakeError(absl::StrCat("Draco failed to encode the mesh: ", status.error_msg_string()),
                     {.reason = Reason::kInternal,
                      .remedy = "Use MESH_ENCODING_PACKED instead, and report this"});
  }
  return std::string(buffer.data(), buffer.size());
}

// ExpertEncoder::SetAttributeExplicitQuantization writes the grid with six decimals, which makes
// small models vanish; the options themselves take any text.
draco::EncoderOptions GridOptions(int attribute, const QuantizationGrid& grid, int bits) {
  draco::Options position;
  position.SetInt("quantization_bits", std::min(bits, kUsefulQuantizationBits));
  const auto exact = [](float value) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.17g", static_cast<double>(value));
    return std::string(text);
  };
  position.SetString("quantization_origin", exact(grid.origin[0]) + " " + exact(grid.origin[1]) +
                                                " " + exact(grid.origin[2]));
  position.SetString("quantization_range", exact(grid.range));
  draco::EncoderOptions options = draco::EncoderOptions::CreateDefaultOptions();
  options.SetAttributeOptions(attribute, position);
  return options;
}

// Draco's points: a vertex is one point for each mark that its corners carry.
struct MarkedPoints {
  std::vector<std::uint32_t> vertex;
  std::vector<std::uint8_t> mark;
  Buffer<Index> corners;
};

MarkedPoints SplitByMark(const MarkedTriangles& triangles, std::size_t vertices) {
  MarkedPoints points;
  points.corners.resize(triangles.corner_vertex.size());
  Buffer<Index> point_of(2 * vertices, kNoIndex);
  for (std::size_t c = 0; c < points.corners.size(); ++c) {
    const Index vertex = triangles.corner_vertex[c];
    const std::uint8_t mark = triangles.added[c];
    Index& point = point_of[2 * std::size_t{vertex} + mark];
    if (point == kNoIndex) {
      point = static_cast<Index>(points.vertex.size());
      points.vertex.push_back(vertex);
      points.mark.push_back(mark);
    }
    points.corners[c] = point;
  }
  return points;
}

absl::Status CheckAllUsed(const PolygonView& faces) {
  std::vector<bool> used(faces.vertex_count);
  for (const Index v : faces.corner_vertex) used[v] = true;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) return IsolatedVertex(v);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> EncodeDracoLossless(const Context& context, const DracoInput& input) {
  LIMN_RETURN_IF_ERROR(CheckSizes(input));
  const std::size_t triangles = input.faces.triangle_count();
  if (input.positions.size() > 3 * triangles) {
    LIMN_RETURN_IF_ERROR(CheckAllUsed(input.faces));
  }
  const Buffer<Index> corners = FanTriangles(input.faces);
  LIMN_RETURN_IF_ERROR(context.Check());
  MeshBuilder builder(input.positions.size(), corners);
  LIMN_RETURN_IF_ERROR(context.Check());
  builder.Add(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT64,
              absl::MakeConstSpan(reinterpret_cast<const char*>(input.positions.data()),
                                  sizeof(Vec3) * input.positions.size()));
  if (!input.normals.empty()) {
    builder.Add(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32, Floats(input.normals));
  }
  if (!input.original_ids.empty()) AddIds(input, &builder);
  if (triangles != input.faces.face_count()) builder.AddArities(input.faces);
  return Encode<draco::MeshSequentialEncoder>(context, builder.mesh(),
                                              draco::EncoderOptions::CreateDefaultOptions());
}

absl::StatusOr<std::string> EncodeDracoQuantized(const Context& context, const DracoInput& input,
                                                 const QuantizationGrid& grid, int bits) {
  LIMN_RETURN_IF_ERROR(CheckSizes(input));
  LIMN_RETURN_IF_ERROR(CheckAllUsed(input.faces));
  LIMN_ASSIGN_OR_RETURN(MarkedTriangles triangles, TriangulateMarked(context, input.faces));
  const bool marked = !triangles.added.empty();
  MarkedPoints points;
  if (marked) points = SplitByMark(triangles, input.positions.size());
  MeshBuilder builder(marked ? points.vertex.size() : input.positions.size(),
                      marked ? points.corners : triangles.corner_vertex);
  std::vector<int> of_vertices = {builder.Add(draco::GeometryAttribute::POSITION, 3,
                                              draco::DT_FLOAT32, Floats(input.positions))};
  draco::EncoderOptions options = GridOptions(of_vertices[0], grid, bits);
  of_vertices.push_back(AddIds(input, &builder));
  if (!input.normals.empty()) {
    of_vertices.push_back(
        builder.Add(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32, Floats(input.normals)));
    if (grid.quantize_normals) {
      options.SetAttributeInt(of_vertices.back(), "quantization_bits", kNormalBits);
    }
  }
  if (marked) {
    for (const int attribute : of_vertices) {
      builder.Map(attribute, [&](std::uint32_t point) { return points.vertex[point]; });
    }
    const int added = builder.Add(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT8,
                                  std::vector<std::uint8_t>{0, 1});
    builder.Name(added, kAddedEdgesName);
    builder.Map(added, [&](std::uint32_t point) { return points.mark[point]; });
  }
  return Encode<draco::MeshEdgebreakerEncoder>(context, builder.mesh(), options);
}

}  // namespace limn::wire
