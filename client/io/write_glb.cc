// SPDX-License-Identifier: MIT
// Binary glTF 2.0, one node with one mesh, by tinygltf.
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <ostream>
#include <streambuf>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "client/io/surface_view.h"
#include "engine/base/error.h"

namespace limn::io {
namespace {

// A std::ostream's way into an OutputFile.
class OutputFileBuffer : public std::streambuf {
 public:
  explicit OutputFileBuffer(OutputFile* file) : file_(file) {}

 protected:
  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    file_->Append({bytes, static_cast<std::size_t>(count)});
    return count;
  }
  int_type overflow(int_type character) override {
    if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(0);
    const char byte = traits_type::to_char_type(character);
    file_->Append({&byte, 1});
    return character;
  }

 private:
  OutputFile* file_;
};

struct Box {
  Vec3 min;
  Vec3 max;
};

Box BoxOf(absl::Span<const Vec3> points) {
  Box box = {points.front(), points.front()};
  for (const Vec3& p : points) {
    box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)};
    box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)};
  }
  return box;
}

// Fills the one buffer, part by part.
class BufferBuilder {
 public:
  BufferBuilder(tinygltf::Model* model, std::uint64_t bytes) : model_(model) {
    model_->buffers.emplace_back();
    model_->buffers.front().data.resize(bytes);
  }

  template <class Value>
  void Append(const Value& value) {
    std::memcpy(model_->buffers.front().data.data() + at_, &value, sizeof value);
    at_ += sizeof value;
  }

  // An accessor to what was appended since the last call.
  int Finish(std::size_t count, int component, int type, int target) {
    tinygltf::BufferView part;
    part.buffer = 0;
    part.byteOffset = begin_;
    part.byteLength = at_ - begin_;
    part.target = target;
    begin_ = at_;
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_->bufferViews.size());
    accessor.componentType = component;
    accessor.count = count;
    accessor.type = type;
    model_->bufferViews.push_back(std::move(part));
    model_->accessors.push_back(std::move(accessor));
    return static_cast<int>(model_->accessors.size()) - 1;
  }

 private:
  tinygltf::Model* model_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;
};

struct Float3 {
  float x;
  float y;
  float z;
};

Float3 ToFloat3(const Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

int AddPositions(const SurfaceView& view, const Vec3& centre, tinygltf::Model* model,
                 BufferBuilder* builder) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  Float3 min = {kLargest, kLargest, kLargest};
  Float3 max = {-kLargest, -kLargest, -kLargest};
  for (const Vec3& point : view.positions) {
    const Float3 p = ToFloat3(point - centre);
    builder->Append(p);
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  const int accessor = builder->Finish(view.positions.size(), TINYGLTF_COMPONENT_TYPE_FLOAT,
                                       TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
  model->accessors[accessor].minValues = {min.x, min.y, min.z};
  model->accessors[accessor].maxValues = {max.x, max.y, max.z};
  return accessor;
}

int AddNormals(const SurfaceView& view, BufferBuilder* builder) {
  for (const Vec3& normal : view.normals) {
    const Vec3 unit = NormalizedOrZero(normal);
    builder->Append(ToFloat3(unit == Vec3{0, 0, 0} ? Vec3{0, 0, 1} : unit));
  }
  return builder->Finish(view.normals.size(), TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3,
                         TINYGLTF_TARGET_ARRAY_BUFFER);
}

int AddTriangles(const SurfaceView& view, std::size_t triangles, BufferBuilder* builder) {
  view.ForEachTriangle([&](Index a, Index b, Index c) {
    builder->Append(a);
    builder->Append(b);
    builder->Append(c);
  });
  return builder->Finish(3 * triangles, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                         TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
}

// A light, matt grey; glTF's default is a metal.
int AddMaterial(tinygltf::Model* model) {
  tinygltf::Material material;
  material.pbrMetallicRoughness.baseColorFactor = {0.8, 0.8, 0.8, 1};
  material.pbrMetallicRoughness.metallicFactor = 0;
  material.pbrMetallicRoughness.roughnessFactor = 0.6;
  model->materials.push_back(std::move(material));
  return 0;
}

}  // namespace

absl::Status WriteGlb(const SurfaceView& view, OutputFile* file) {
  const std::size_t triangles = view.triangle_count();
  if (view.positions.empty() || triangles == 0) {
    return MakeError(
        "a surface without faces cannot be written as .glb",
        {.reason = Reason::kEmptyMesh, .field = "faces", .remedy = "Write .ply or .obj"});
  }
  const std::uint64_t bytes =
      12 * std::uint64_t{view.positions.size() + view.normals.size()} + 12 * triangles;
  constexpr std::uint64_t kRoomForJson = 4096;
  if (bytes > std::numeric_limits<std::uint32_t>::max() - kRoomForJson) {
    return MakeError(absl::StrCat(bytes, " bytes are more than a .glb file can hold"),
                     {.reason = Reason::kLimitExceeded,
                      .field = "level",
                      .remedy = "Ask for a lower level or write .ply"});
  }
  // Halves first, so that the sum cannot overflow.
  const Box box = BoxOf(view.positions);
  const Vec3 centre = 0.5 * box.min + 0.5 * box.max;
  LIMN_RETURN_IF_ERROR(CheckFloat32(view, centre, "glTF"));

  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "Limn " LIMN_VERSION;
  BufferBuilder builder(&model, bytes);
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] = AddPositions(view, centre, &model, &builder);
  if (!view.normals.empty()) primitive.attributes["NORMAL"] = AddNormals(view, &builder);
  primitive.indices = AddTriangles(view, triangles, &builder);
  primitive.material = AddMaterial(&model);
  tinygltf::Mesh mesh;
  mesh.primitives.push_back(std::move(primitive));
  model.meshes.push_back(std::move(mesh));
  tinygltf::Node node;
  node.mesh = 0;
  node.translation = {centre.x, centre.y, centre.z};
  model.nodes.push_back(std::move(node));
  tinygltf::Scene scene;
  scene.nodes.push_back(0);
  model.scenes.push_back(std::move(scene));
  model.defaultScene = 0;

  OutputFileBuffer buffer(file);
  std::ostream stream(&buffer);
  tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, stream, /*prettyPrint=*/false,
                                              /*writeBinary=*/true);
  return absl::OkStatus();
}

}  // namespace limn::io
