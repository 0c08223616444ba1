// SPDX-License-Identifier: MIT
// Draco files as other programs write them, for the tests of the decoder.
#pragma once

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/wire/test_meshes.h"

namespace limn::wire {

// A Draco mesh as another program would make it: an attribute of any type, no names, no ids.
template <class T>
std::unique_ptr<draco::Mesh> ForeignMesh(const PolygonMesh& mesh, draco::DataType type) {
  auto out = std::make_unique<draco::Mesh>();
  out->set_num_points(static_cast<std::uint32_t>(mesh.vertex_count()));
  out->SetNumFaces(mesh.face_count());
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    draco::Mesh::Face face;
    for (int i = 0; i < 3; ++i) face[i] = draco::PointIndex(mesh.face(f)[i]);
    out->SetFace(draco::FaceIndex(f), face);
  }
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, type, false, 3 * sizeof(T), 0);
  const int id = out->AddAttribute(position, true, out->num_points());
  for (std::uint32_t v = 0; v < out->num_points(); ++v) {
    const Vec3 p = mesh.positions[v];
    const std::array<T, 3> value = {static_cast<T>(p.x), static_cast<T>(p.y), static_cast<T>(p.z)};
    out->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), value.data());
  }
  return out;
}

// Float attributes are quantised to 14 bits.
inline std::string ForeignBytes(const draco::Mesh& mesh, int method, int speed,
                                bool compress_connectivity = false) {
  draco::ExpertEncoder encoder(mesh);
  draco::EncoderOptions options = draco::EncoderOptions::CreateDefaultOptions();
  options.SetGlobalBool("compress_connectivity", compress_connectivity);
  encoder.Reset(options);
  encoder.SetEncodingMethod(method);
  encoder.SetSpeedOptions(speed, speed);
  for (int a = 0; a < mesh.num_attributes(); ++a) {
    if (mesh.attribute(a)->data_type() == draco::DT_FLOAT32) {
      encoder.SetAttributeQuantization(a, 14);
    }
  }
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
  return std::string(buffer.data(), buffer.size());
}

// Adds a normal and a texture coordinate to every point.
inline void AddForeignAttributes(draco::Mesh* mesh) {
  for (const auto type : {draco::GeometryAttribute::NORMAL, draco::GeometryAttribute::TEX_COORD}) {
    const std::uint8_t components = type == draco::GeometryAttribute::NORMAL ? 3 : 2;
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, components, draco::DT_FLOAT32, false, components * 4, 0);
    const int id = mesh->AddAttribute(attribute, true, mesh->num_points());
    for (std::uint32_t v = 0; v < mesh->num_points(); ++v) {
      const std::array<float, 3> value = {0.5F, 0.25F + static_cast<float>(v % 7), 1};
      mesh->attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v), value.data());
    }
  }
}

// Triangles, with integer coordinates up to 100.
inline PolygonMesh TriangleTorus() {
  PolygonMesh quads = Torus(12, 9);
  PolygonMesh mesh;
  for (const Vec3& p : quads.positions) {
    mesh.positions.push_back(
        {std::round(50 + 12 * p.x), std::round(50 + 12 * p.y), std::round(50 + 12 * p.z)});
  }
  for (std::size_t f = 0; f < quads.face_count(); ++f) {
    const auto q = quads.face(f);
    mesh.AddFace(std::vector<Index>{q[0], q[1], q[2]});
    mesh.AddFace(std::vector<Index>{q[0], q[2], q[3]});
  }
  return mesh;
}

}  // namespace limn::wire
