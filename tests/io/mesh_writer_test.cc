// SPDX-License-Identifier: MIT
// What WriteMeshFile and WriteSurfaceFile promise: nothing lost, nothing half-written.
#include "client/io/mesh_writer.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <limits>
#include <string>

#include "client/io/mesh_reader.h"
#include "engine/base/error.h"
#include "engine/mesh/generate.h"
#include "tests/io/test_files.h"

namespace limn {
namespace {

class MeshWriterTest : public testing::Test {
 protected:
  PolygonMesh ReadBack(const std::string& name) {
    absl::StatusOr<PolygonMesh> mesh = ReadMeshFile(folder_.path(name));
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    return mesh.ok() ? *std::move(mesh) : PolygonMesh();
  }
  void ExpectReason(const absl::Status& status, Reason reason, const std::string& part) {
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(ReasonName(GetErrorDetail(status)->reason), ReasonName(reason)) << status;
    EXPECT_NE(std::string(status.message()).find(part), std::string::npos) << status;
  }

  TempFolder folder_;
};

PolygonMesh Sphere(std::uint64_t vertices) {
  return *GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = vertices});
}

// Two quads and, as normals, numbers that are float32 values.
Tessellation TwoQuads() {
  Tessellation surface;
  surface.level = 1;
  surface.arity = 4;
  surface.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 1.0 / 3}, {2, 0, 0}, {2, 1, 0}};
  surface.normals.assign(6, Vec3{0, 0, 1});
  surface.normals[1] = {0.6F, 0, 0.8F};
  surface.face_vertices = {0, 1, 2, 3, 1, 4, 5, 2};
  return surface;
}

TEST_F(MeshWriterTest, LosslessFormatsGiveBackTheSameMesh) {
  PolygonMesh mesh = Sphere(300);
  mesh.positions[0] = {1.0 / 3, -1e300, 5e-324};
  mesh.positions[1] = {0.1 + 0.2, 1.7976931348623157e308, 123456789.123456789};
  for (const std::string name : {"a.obj", "a.off", "a.ply", "a.OBJ"}) {
    const absl::Status status = WriteMeshFile(folder_.path(name), mesh);
    ASSERT_TRUE(status.ok()) << status;
    EXPECT_EQ(ReadBack(name), mesh) << name;
  }
}

TEST_F(MeshWriterTest, InvalidMeshesAreWrittenAsTheyAre) {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}};
  for (const auto& face : {std::vector<Index>{0, 1, 2}, {0, 1}, {1, 2, 2, 1}, {}}) {
    mesh.AddFace(face);
  }
  for (const std::string name : {"a.obj", "a.off", "a.ply"}) {
    ASSERT_TRUE(WriteMeshFile(folder_.path(name), mesh).ok());
    EXPECT_EQ(ReadBack(name), mesh) << name;
  }
}

TEST_F(MeshWriterTest, LongFacesFitIntoPly) {
  PolygonMesh mesh;
  Buffer<Index> face;
  for (Index v = 0; v < 300; ++v) {
    mesh.positions.push_back({std::cos(v / 50.0), std::sin(v / 50.0), 0});
    face.push_back(v);
  }
  mesh.AddFace(face);
  ASSERT_TRUE(WriteMeshFile(folder_.path("a.ply"), mesh).ok());
  EXPECT_EQ(ReadBack("a.ply"), mesh);
}

TEST_F(MeshWriterTest, StlHasTheSameSurfaceInTriangles) {
  const PolygonMesh mesh = Sphere(200);
  ASSERT_TRUE(WriteMeshFile(folder_.path("a.stl"), mesh).ok());
  const PolygonMesh back = ReadBack("a.stl");
  EXPECT_EQ(back.vertex_count(), mesh.vertex_count());
  EXPECT_EQ(back.face_count(), mesh.corner_count() - 2 * mesh.face_count());
  for (const Vec3& p : back.positions) {
    const bool found = std::any_of(mesh.positions.begin(), mesh.positions.end(), [&](Vec3 q) {
      return p == Vec3{static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z)};
    });
    EXPECT_TRUE(found);
  }
}

TEST_F(MeshWriterTest, SurfaceObjHasFullDigitsAndNormals) {
  ASSERT_TRUE(WriteSurfaceFile(folder_.path("a.obj"), TwoQuads()).ok());
  const std::string text = folder_.Read("a.obj");
  EXPECT_NE(text.find("v 0 1 0.3333333333333333\n"), std::string::npos) << text;
  EXPECT_NE(text.find("vn 0.6 0 0.8\n"), std::string::npos) << text;
  EXPECT_NE(text.find("f 2//2 5//5 6//6 3//3\n"), std::string::npos) << text;
}

TEST_F(MeshWriterTest, SurfacesReadBackInEveryFormat) {
  const Tessellation surface = TwoQuads();
  Tessellation polygons = surface;  // level 0: arities of its own, no normals
  polygons.arity = 0;
  polygons.normals.clear();
  polygons.face_begin = {0, 3, 8};
  for (const std::string name : {"a.obj", "a.off", "a.ply"}) {
    ASSERT_TRUE(WriteSurfaceFile(folder_.path(name), surface).ok());
    PolygonMesh back = ReadBack(name);
    EXPECT_EQ(back.positions, surface.positions);
    EXPECT_EQ(back.corner_vertex, surface.face_vertices);
    EXPECT_EQ(back.face_begin, (Buffer<Index>{0, 4, 8}));
    ASSERT_TRUE(WriteSurfaceFile(folder_.path(name), polygons).ok());
    back = ReadBack(name);
    EXPECT_EQ(back.face_begin, polygons.face_begin);
  }
}

TEST_F(MeshWriterTest, QuadsAreCutAlongTheShorterDiagonal) {
  Tessellation surface;
  surface.arity = 4;
  surface.positions = {{0, 0, 0}, {1, -0.2, 0}, {3, 0, 0}, {1, 0.2, 0}};
  surface.face_vertices = {0, 1, 2, 3};
  ASSERT_TRUE(WriteSurfaceFile(folder_.path("a.stl"), surface).ok());
  const PolygonMesh back = ReadBack("a.stl");
  // Numbered by first occurrence: 0, 1, 3, then 2.
  EXPECT_EQ(back.corner_vertex, (Buffer<Index>{0, 1, 2, 1, 3, 2}));
}

class GlbTest : public MeshWriterTest {
 protected:
  tinygltf::Model Load(const std::string& name) {
    tinygltf::Model model;
    std::string error;
    std::string warning;
    EXPECT_TRUE(
        tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &error, &warning, folder_.path(name)))
        << error;
    EXPECT_EQ(error + warning, "");
    return model;
  }
  template <class T>
  static std::vector<T> Values(const tinygltf::Model& model, int accessor, std::size_t width) {
    const tinygltf::Accessor& values = model.accessors[static_cast<std::size_t>(accessor)];
    const tinygltf::BufferView& part =
        model.bufferViews[static_cast<std::size_t>(values.bufferView)];
    std::vector<T> out(values.count * width);
    EXPECT_EQ(part.byteLength, out.size() * sizeof(T));
    std::memcpy(out.data(), model.buffers[0].data.data() + part.byteOffset, part.byteLength);
    return out;
  }
};

TEST_F(GlbTest, FarFromTheOriginNothingIsLost) {
  Tessellation surface = TwoQuads();
  const Vec3 offset = {1e7, -2e7, 3e7};
  for (Vec3& p : surface.positions) p += offset;
  ASSERT_TRUE(WriteSurfaceFile(folder_.path("a.glb"), surface).ok());
  const tinygltf::Model model = Load("a.glb");
  ASSERT_EQ(model.nodes.size(), 1U);
  const std::vector<double>& centre = model.nodes[0].translation;
  ASSERT_EQ(centre.size(), 3U);
  const tinygltf::Primitive& primitive = model.meshes[0].primitives[0];
  const auto points = Values<float>(model, primitive.attributes.at("POSITION"), 3);
  ASSERT_EQ(points.size(), 18U);
  for (std::size_t v = 0; v < 6; ++v) {
    EXPECT_NEAR(centre[0] + points[3 * v], surface.positions[v].x, 1e-7);
    EXPECT_NEAR(centre[1] + points[3 * v + 1], surface.positions[v].y, 1e-7);
    EXPECT_NEAR(centre[2] + points[3 * v + 2], surface.positions[v].z, 1e-7);
  }
  const tinygltf::Accessor& accessor =
      model.accessors[static_cast<std::size_t>(primitive.attributes.at("POSITION"))];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float low = points[axis];
    float high = points[axis];
    for (std::size_t v = 1; v < 6; ++v) {
      low = std::min(low, points[3 * v + axis]);
      high = std::max(high, points[3 * v + axis]);
    }
    EXPECT_EQ(accessor.minValues[axis], low);
    EXPECT_EQ(accessor.maxValues[axis], high);
  }
}

TEST_F(GlbTest, HasTrianglesAndUnitNormals) {
  Tessellation surface = TwoQuads();
  surface.normals[3] = {0, 0, 0};
  ASSERT_TRUE(WriteSurfaceFile(folder_.path("a.glb"), surface).ok());
  const tinygltf::Model model = Load("a.glb");
  const tinygltf::Primitive& primitive = model.meshes[0].primitives[0];
  EXPECT_EQ(primitive.mode, TINYGLTF_MODE_TRIANGLES);
  const auto triangles = Values<std::uint32_t>(model, primitive.indices, 1);
  EXPECT_EQ(triangles.size(), 12U);
  for (const std::uint32_t v : triangles) EXPECT_LT(v, 6U);
  const auto normals = Values<float>(model, primitive.attributes.at("NORMAL"), 3);
  ASSERT_EQ(normals.size(), 18U);
  EXPECT_NEAR(normals[3], 0.6, 1e-7);
  for (std::size_t v = 0; v < 6; ++v) {
    EXPECT_NEAR(std::hypot(normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]), 1, 1e-6);
  }
}

TEST_F(GlbTest, NormalsAreOptional) {
  Tessellation surface = TwoQuads();
  surface.normals.clear();
  ASSERT_TRUE(WriteSurfaceFile(folder_.path("a.glb"), surface).ok());
  EXPECT_EQ(Load("a.glb").meshes[0].primitives[0].attributes.count("NORMAL"), 0U);
}

TEST_F(MeshWriterTest, UnknownExtensionsListTheKnownOnesBeforeTheWork) {
  ExpectReason(CheckWritable(folder_.path("a.xyz"), OutputKind::kSurface), Reason::kInvalidOption,
               ".obj, .off, .ply, .stl, .glb");
  ExpectReason(CheckWritable(folder_.path("a.glb"), OutputKind::kMesh), Reason::kInvalidOption,
               "Known extensions are .obj, .off, .ply, .stl");
  ExpectReason(WriteMeshFile(folder_.path("a"), Sphere(9)), Reason::kInvalidOption, "extension");
  EXPECT_EQ(folder_.size(), 0U);
}

TEST_F(MeshWriterTest, CheckWritableLeavesNothingBehindAndChangesNothing) {
  folder_.Write("old.obj", "old");
  EXPECT_TRUE(CheckWritable(folder_.path("old.obj"), OutputKind::kMesh).ok());
  EXPECT_TRUE(CheckWritable(folder_.path("new.glb"), OutputKind::kSurface).ok());
  EXPECT_EQ(folder_.Read("old.obj"), "old");
  EXPECT_EQ(folder_.size(), 1U);
}

TEST_F(MeshWriterTest, UnwritablePlacesAreRefused) {
  EXPECT_EQ(CheckWritable(folder_.path("none/a.obj"), OutputKind::kMesh).code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(WriteMeshFile(folder_.path("none/a.obj"), Sphere(9)).code(),
            absl::StatusCode::kNotFound);
  // Nobody, not even root, can make files there.
  EXPECT_FALSE(CheckWritable("/proc/a.obj", OutputKind::kMesh).ok());
  std::filesystem::create_directory(folder_.path("folder.obj"));
  ExpectReason(CheckWritable(folder_.path("folder.obj"), OutputKind::kMesh), Reason::kInvalidOption,
               "not a regular file");
  std::filesystem::create_symlink("/dev/null", folder_.path("null.obj"));
  ExpectReason(WriteMeshFile(folder_.path("null.obj"), Sphere(9)), Reason::kInvalidOption,
               "not a regular file");
}

TEST_F(MeshWriterTest, FullDiskLeavesTheOldFileAndNothingElse) {
  folder_.Write("a.obj", "old");
  rlimit old = {};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit small = {5000, old.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const absl::Status mesh = WriteMeshFile(folder_.path("a.obj"), Sphere(1000));
  Tessellation surface;
  const PolygonMesh sphere = Sphere(1000);
  surface.positions = sphere.positions;
  surface.face_begin = sphere.face_begin;
  surface.face_vertices = sphere.corner_vertex;
  const absl::Status glb = WriteSurfaceFile(folder_.path("a.glb"), surface);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_FALSE(mesh.ok());
  EXPECT_FALSE(glb.ok());
  EXPECT_NE(std::string(mesh.message()).find("a.obj"), std::string::npos) << mesh;
  EXPECT_EQ(folder_.Read("a.obj"), "old");
  EXPECT_EQ(folder_.size(), 1U);
}

TEST_F(MeshWriterTest, RefusedContentLeavesTheOldFile) {
  folder_.Write("a.stl", "old");
  PolygonMesh mesh = Sphere(20);
  mesh.positions[7].y = 1e39;
  ExpectReason(WriteMeshFile(folder_.path("a.stl"), mesh), Reason::kCoordinateTooLarge, "vertex 7");
  mesh.positions[7].y = std::numeric_limits<double>::quiet_NaN();
  ExpectReason(WriteMeshFile(folder_.path("a.stl"), mesh), Reason::kNonFiniteCoordinate,
               "vertex 7");
  mesh.corner_vertex[5] = 20;
  ExpectReason(WriteMeshFile(folder_.path("a.stl"), mesh), Reason::kIndexOutOfRange, "corner 5");
  mesh.face_begin[1] = 10000;
  ExpectReason(WriteMeshFile(folder_.path("a.stl"), mesh), Reason::kMalformedRequest, "face_begin");
  EXPECT_EQ(folder_.Read("a.stl"), "old");
  EXPECT_EQ(folder_.size(), 1U);
}

TEST_F(MeshWriterTest, SurfacesThatGlbCannotHoldAreRefused) {
  ExpectReason(WriteSurfaceFile(folder_.path("a.glb"), Tessellation()), Reason::kEmptyMesh,
               "without faces");
  Tessellation surface = TwoQuads();
  surface.normals.pop_back();
  ExpectReason(WriteSurfaceFile(folder_.path("a.glb"), surface), Reason::kMalformedRequest,
               "5 normals for 6 vertices");
  EXPECT_EQ(folder_.size(), 0U);
}

TEST_F(MeshWriterTest, LinksAreFollowedAndPermissionsKept) {
  folder_.Write("real.obj", "old");
  std::filesystem::permissions(folder_.path("real.obj"), std::filesystem::perms(0640));
  std::filesystem::create_symlink("real.obj", folder_.path("link.obj"));
  ASSERT_TRUE(WriteMeshFile(folder_.path("link.obj"), Sphere(50)).ok());
  EXPECT_TRUE(std::filesystem::is_symlink(folder_.path("link.obj")));
  EXPECT_EQ(ReadBack("real.obj"), Sphere(50));
  EXPECT_EQ(std::filesystem::status(folder_.path("real.obj")).permissions(),
            std::filesystem::perms(0640));
}

}  // namespace
}  // namespace limn
