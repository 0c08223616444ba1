// SPDX-License-Identifier: MIT
// Damaged files: any outcome but a crash, a hang or a mesh whose indices are out of range.
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "client/io/mesh_collector.h"
#include "client/io/mesh_writer.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/mesh_info.h"
#include "tests/io/test_files.h"

namespace limn {
namespace {

// A format, as text or binary, with a sound file of it.
struct Format {
  std::string name;
  absl::Status (*read)(std::string_view bytes, io::MeshCollector* collector);
  std::string sound;
};

constexpr char kPlyText[] =
    "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty double x\nproperty double y\n"
    "property double z\nproperty uchar red\nelement face 3\nproperty list uchar int "
    "vertex_indices\nproperty list int float more\nend_header\n0 0 0 1\n1 0 0 2\n0 1 0 3\n"
    "1 1 1 4\n3 0 1 2 0\n4 0 1 2 3 1 0.5\n3 2 1 3 2 1 1\n";
constexpr char kStlText[] =
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    "endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 1 0\nvertex 1 0 0\n"
    "vertex 1 1 1e0\nendloop\nendfacet\nendsolid x\n";
constexpr char kObjText[] =
    "# x\nmtllib a.mtl\nv 0 0 0\nv 1 0 0 1\nv 0 1.5e-3 0\nvn 0 0 1\nvt 0 0\ng a b\n"
    "f 1/1/1 2//1 3/1\nf -1 -2 \\\n -3\nv 1 1 1\nf 2 4 3\n";

std::string Written(const std::string& name) {
  const TempFolder folder;
  const auto mesh = GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 12});
  EXPECT_TRUE(WriteMeshFile(folder.path(name), *mesh).ok());
  return folder.Read(name);
}

std::vector<Format> Formats() {
  return {{"obj", io::ReadObj, Written("a.obj")}, {"obj_by_hand", io::ReadObj, kObjText},
          {"off", io::ReadOff, Written("a.off")}, {"ply_binary", io::ReadPly, Written("a.ply")},
          {"ply_text", io::ReadPly, kPlyText},    {"stl_binary", io::ReadStl, Written("a.stl")},
          {"stl_text", io::ReadStl, kStlText}};
}

class MeshReaderFuzzTest : public testing::TestWithParam<Format> {
 protected:
  static absl::StatusOr<PolygonMesh> Read(const std::string& bytes) {
    io::MeshCollector collector("fuzz");
    if (absl::Status status = GetParam().read(bytes, &collector); !status.ok()) return status;
    return collector.Take();
  }

  static void ReadDamaged(const std::string& bytes) {
    const auto mesh = Read(bytes);
    if (!mesh.ok()) {
      EXPECT_FALSE(mesh.status().message().empty());
      return;
    }
    for (const Index v : mesh->corner_vertex) ASSERT_LT(v, mesh->vertex_count());
    (void)DescribeMesh(*mesh);
  }
};

TEST_P(MeshReaderFuzzTest, ReadsTheSoundFile) {
  const auto mesh = Read(GetParam().sound);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_GE(mesh->face_count(), 2U);
}

TEST_P(MeshReaderFuzzTest, SurvivesTruncationAnywhere) {
  const std::string& sound = GetParam().sound;
  for (std::size_t size = 0; size < sound.size(); ++size) ReadDamaged(sound.substr(0, size));
}

TEST_P(MeshReaderFuzzTest, SurvivesChangedBytes) {
  constexpr std::uint64_t kSeed = 20240607;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 20000; ++round) {
    std::string damaged = GetParam().sound;
    for (std::uint64_t changes = 1 + random() % 4; changes > 0; --changes) {
      const std::size_t at = random() % damaged.size();
      switch (random() % 4) {
        case 0:
          damaged[at] = static_cast<char>(random());
          break;
        case 1:
          damaged[at] = "0123456789-.e \n#/\\"[random() % 18];
          break;
        case 2:
          damaged.erase(at, 1 + random() % 8);
          break;
        default:
          damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 16));
      }
      if (damaged.empty()) damaged = "x";
    }
    ReadDamaged(damaged);
  }
}

TEST_P(MeshReaderFuzzTest, SurvivesRandomBytes) {
  constexpr std::uint64_t kSeed = 77;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 5000; ++round) {
    std::string bytes(random() % 400, '\0');
    for (char& byte : bytes) byte = static_cast<char>(random());
    ReadDamaged(bytes);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, MeshReaderFuzzTest, testing::ValuesIn(Formats()),
                         [](const auto& format) { return format.param.name; });

}  // namespace
}  // namespace limn
