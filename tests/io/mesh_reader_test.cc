// SPDX-License-Identifier: MIT
// What ReadMeshFile promises, format by format.
#include "client/io/mesh_reader.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/mesh/half_edge_mesh.h"
#include "tests/io/test_files.h"

namespace limn {
namespace {

class MeshReaderTest : public testing::Test {
 protected:
  PolygonMesh Read(const std::string& name, std::string_view bytes) {
    absl::StatusOr<PolygonMesh> mesh = ReadMeshFile(folder_.Write(name, bytes));
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    return mesh.ok() ? *std::move(mesh) : PolygonMesh();
  }

  // Expects an error of that reason whose message has `part` in it.
  void ExpectError(const std::string& name, std::string_view bytes, Reason reason,
                   const std::string& part) {
    const absl::Status status = ReadMeshFile(folder_.Write(name, bytes)).status();
    ASSERT_FALSE(status.ok()) << bytes.substr(0, 200);
    EXPECT_EQ(ReasonName(GetErrorDetail(status)->reason), ReasonName(reason)) << status;
    EXPECT_NE(std::string(status.message()).find(part), std::string::npos) << status;
    EXPECT_NE(std::string(status.message()).find(name), std::string::npos) << status;
  }

  TempFolder folder_;
};

using Faces = std::vector<std::vector<Index>>;

Faces FacesOf(const PolygonMesh& mesh) {
  Faces faces;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    faces.emplace_back(mesh.face(f).begin(), mesh.face(f).end());
  }
  return faces;
}

// Values that float32 or six digits would spoil.
constexpr char kHardNumbers[] =
    "0.1234567890123456789 -1e300 5e-324\n"
    "+1.7976931348623157e308 -0 0.30000000000000004\n"
    "9007199254740993 1e-400 3.\n";

void ExpectHardNumbers(const PolygonMesh& mesh) {
  ASSERT_GE(mesh.vertex_count(), 3U);
  EXPECT_EQ(mesh.positions[0], (Vec3{0.1234567890123456789, -1e300, 5e-324}));
  EXPECT_EQ(mesh.positions[1], (Vec3{1.7976931348623157e308, 0, 0.1 + 0.2}));
  EXPECT_TRUE(std::signbit(mesh.positions[1].y));
  EXPECT_EQ(mesh.positions[2], (Vec3{9007199254740992, 0, 3}));
}

TEST_F(MeshReaderTest, DecimalsBecomeTheNearestDoubles) {
  std::string obj;
  std::istringstream lines(kHardNumbers);
  for (std::string line; std::getline(lines, line);) obj += "v " + line + "\n";
  ExpectHardNumbers(Read("a.obj", obj + "f 1 2 3\n"));
  ExpectHardNumbers(Read("a.off", "OFF\n3 1 0\n" + std::string(kHardNumbers) + "3 0 1 2\n"));
  ExpectHardNumbers(Read("a.ply",
                         "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\n"
                         "property double y\nproperty double z\nelement face 1\n"
                         "property list uchar int vertex_indices\nend_header\n" +
                             std::string(kHardNumbers) + "3 0 1 2\n"));
}

TEST_F(MeshReaderTest, NonFiniteCoordinatesComeThroughForValidation) {
  const PolygonMesh mesh = Read("a.obj", "v nan inf -inf\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_TRUE(std::isnan(mesh.positions[0].x));
  EXPECT_EQ(mesh.positions[0].y, std::numeric_limits<double>::infinity());
  EXPECT_EQ(mesh.positions[0].z, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(mesh.positions[1].x, std::numeric_limits<double>::infinity());
}

TEST_F(MeshReaderTest, ObjFacesInAllTheirSpellings) {
  const PolygonMesh mesh = Read("cube.OBJ",
                                "# comment\r\nmtllib x.mtl\no thing #1\r\n"
                                "v 0 0 0 1 0.5 0.5 0.5\r\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvt 0 0\n"
                                "f 1/1/1 2//1 3/1\n"
                                "f -3 -2 -1\n"
                                "v 0 1 0\n"
                                "\tf  1 2 \\\n 3 4 # end\n"
                                "f -4 -1 5\n"  // a vertex that comes later
                                "v 9 9 9");
  EXPECT_EQ(FacesOf(mesh), (Faces{{0, 1, 2}, {0, 1, 2}, {0, 1, 2, 3}, {0, 3, 4}}));
  EXPECT_EQ(mesh.positions[4], (Vec3{9, 9, 9}));
}

TEST_F(MeshReaderTest, OffWithAttributesCommentsAndWithoutMagic) {
  const Faces expected = {{0, 1, 2}, {2, 1, 3}};
  const std::string body =
      "0 0 0 255 0 0 255\n# comment\n1 0 0 # more\n\n0 1 0\n1 1 0\n"
      "3 0 1 2 255 0 0\n3  2 1 3\n\n# end\n";
  EXPECT_EQ(FacesOf(Read("a.off", "OFF 4 2 0\n" + body)), expected);
  EXPECT_EQ(FacesOf(Read("b.off", "COFF\n# here too\n4 2\n" + body)), expected);
  EXPECT_EQ(FacesOf(Read("c.off", "STCNOFF\n4 2 5\n" + body)), expected);
  EXPECT_EQ(FacesOf(Read("d.off", "4 2 5\n" + body)), expected);
}

std::string Bytes(const auto& value, bool big_endian) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
  return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

TEST_F(MeshReaderTest, BinaryPlyOfBothByteOrders) {
  for (const bool big : {false, true}) {
    std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                        "_endian 1.0\ncomment x\nobj_info y\nelement extra 1\n"
                        "property list ushort double junk\nelement vertex 3\n"
                        "property uchar red\nproperty double x\nproperty float y\n"
                        "property short z\nelement face 2\nproperty int flags\n"
                        "property list uint8 ushort vertex_index\nend_header\n";
    bytes += Bytes(std::uint16_t{2}, big) + Bytes(1.5, big) + Bytes(2.5, big);
    for (int v = 0; v < 3; ++v) {
      bytes += Bytes(std::uint8_t{200}, big) + Bytes(0.1 * v, big) + Bytes(0.1F * v, big) +
               Bytes(static_cast<std::int16_t>(-v), big);
    }
    for (const auto& face : Faces{{0, 1, 2}, {2, 1}}) {
      bytes += Bytes(std::int32_t{7}, big) + Bytes(static_cast<std::uint8_t>(face.size()), big);
      for (const Index v : face) bytes += Bytes(static_cast<std::uint16_t>(v), big);
    }
    const PolygonMesh mesh = Read("a.ply", bytes);
    EXPECT_EQ(FacesOf(mesh), (Faces{{0, 1, 2}, {2, 1}}));
    ASSERT_EQ(mesh.vertex_count(), 3U);
    EXPECT_EQ(mesh.positions[2], (Vec3{0.2, 0.2F, -2}));
    for (std::size_t cut = 1; cut < 30; ++cut) {
      ExpectError("b.ply", bytes.substr(0, bytes.size() - cut), Reason::kMalformedFile, "");
    }
  }
}

TEST_F(MeshReaderTest, StlMergesEqualCornersOnly) {
  const PolygonMesh mesh = Read("a.stl",
                                "solid facet of a name\n"
                                "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n"
                                "  vertex 1 0 0\n  vertex 0 0.1234567890123456 0\n endloop\n"
                                "endfacet\n"
                                "facet normal 0 0 1\n outer loop\n  vertex 0 0.1234567890123457 0\n"
                                "  vertex 1 0 0\n  vertex -0.0 0 0\n endloop\nendfacet\n"
                                "facet normal 0 0 1 outer loop vertex 1 0 0 vertex 1 0 0\n"
                                "vertex 0 0 0 endloop endfacet\nendsolid facet of a name\n");
  EXPECT_EQ(FacesOf(mesh), (Faces{{0, 1, 2}, {3, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(mesh.positions[2].y, 0.1234567890123456);
}

TEST_F(MeshReaderTest, BinaryStlEvenIfItBeginsWithSolid) {
  std::string bytes = "solid but binary";
  bytes.resize(80, ' ');
  bytes += Bytes(std::uint32_t{2}, false);
  const float corners[2][9] = {{0, 0, 0, 1, 0, 0, 0, 0.1F, 0}, {0, 0.1F, 0, 1, 0, 0, 1, 1, 1}};
  for (const auto& corner : corners) {
    bytes += std::string(12, '\0') + Bytes(corner, false) + std::string(2, '\0');
  }
  const PolygonMesh mesh = Read("a.stl", bytes);
  EXPECT_EQ(FacesOf(mesh), (Faces{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(mesh.positions[2], (Vec3{0, 0.1F, 0}));
  bytes[0] = 'x';
  ExpectError("cut.stl", bytes.substr(0, bytes.size() - 1), Reason::kMalformedFile, "2 triangles");
}

// Each keeps its defect, so that Build can name it.
TEST_F(MeshReaderTest, InvalidTopologyReachesValidation) {
  struct Case {
    const char* body;
    Reason reason;
  };
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
  for (const Case& c : {Case{"f 1 2 3\nf 1 2\n", Reason::kFaceTooSmall},
                        Case{"f 1 2 3\nf\n", Reason::kFaceTooSmall},
                        Case{"f 1 2 3\nf 1 2 2 4\n", Reason::kRepeatedVertex},
                        Case{"f 1 2 3\n", Reason::kIsolatedVertex},
                        Case{"f 1 2 3\nf 1 2 4\n", Reason::kInconsistentOrientation}}) {
    const PolygonMesh mesh = Read("a.obj", vertices + c.body);
    const absl::Status status = HalfEdgeMesh::Build(Context(), mesh).status();
    ASSERT_FALSE(status.ok()) << c.body;
    EXPECT_EQ(ReasonName(GetErrorDetail(status)->reason), ReasonName(c.reason)) << c.body;
  }
}

TEST_F(MeshReaderTest, MissingFileIsNotFound) {
  EXPECT_EQ(ReadMeshFile(folder_.path("none.obj")).status().code(), absl::StatusCode::kNotFound);
}

TEST_F(MeshReaderTest, UnknownExtensionListsTheKnown) {
  ExpectError("a.fbx", "x", Reason::kInvalidOption, ".obj, .off, .ply and .stl");
  ExpectError("noextension", "x", Reason::kInvalidOption, ".obj, .off, .ply and .stl");
}

TEST_F(MeshReaderTest, FolderIsRefused) {
  std::filesystem::create_directory(folder_.path("folder.obj"));
  const absl::Status status = ReadMeshFile(folder_.path("folder.obj")).status();
  EXPECT_EQ(GetErrorDetail(status)->reason, Reason::kMalformedFile) << status;
  std::filesystem::create_directory(folder_.path("folder"));
  EXPECT_EQ(GetErrorDetail(ReadMeshFile(folder_.path("folder")).status())->reason,
            Reason::kMalformedFile);
}

TEST_F(MeshReaderTest, NoFacesIsAnEmptyMesh) {
  ExpectError("a.obj", "", Reason::kEmptyMesh, "0 vertices and 0 faces");
  ExpectError("b.obj", "v 0 0 0\n", Reason::kEmptyMesh, "1 vertices and 0 faces");
  ExpectError("c.off", "OFF\n1 0 0\n0 0 0\n", Reason::kEmptyMesh, "1 vertices and 0 faces");
  ExpectError("d.stl", "solid x\nendsolid x\n", Reason::kEmptyMesh, "0 faces");
}

TEST_F(MeshReaderTest, IndexOutOfRangeNamesTheFace) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  ExpectError("a.obj", obj + "f 1 2 4\n", Reason::kIndexOutOfRange, "line 5: face 1");
  ExpectError("b.obj", obj + "f 1 2 0\n", Reason::kIndexOutOfRange, "line 5: face 1");
  ExpectError("c.obj", obj + "f 1 2 -4\n", Reason::kIndexOutOfRange, "line 5: face 1");
  ExpectError("d.obj", obj + "f 1 2 5000000000\n", Reason::kIndexOutOfRange, "line 5: face 1");
  const std::string off = "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  ExpectError("a.off", off + "3 0 1 3\n", Reason::kIndexOutOfRange, "line 7: face 1");
  ExpectError("b.off", off + "3 0 1 -1\n", Reason::kIndexOutOfRange, "line 7: face 1");
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list char int vertex_index\nend_header\n0 0 0\n";
  ExpectError("a.ply", ply + "3 0 0 1\n", Reason::kIndexOutOfRange, "line 11: face 0");
}

TEST_F(MeshReaderTest, MalformedTextIsRefusedWithItsLine) {
  const auto expect = [&](const std::string& name, const std::string& bytes,
                          const std::string& part) {
    ExpectError(name, bytes, Reason::kMalformedFile, part);
  };
  expect("a.obj", "v 0 0\n", "line 1: a coordinate should be a number, not the end of the line");
  expect("a.obj", "v 0 0 0\n\nv 0 0 zero\n", "line 3");
  expect("a.obj", "v 0 0 0x10\n", "\"0x10\"");
  expect("a.obj", "v 0 0 ++1\n", "\"++1\"");
  expect("a.obj", "v 0 0 0\nf 1 2a 3\n", "line 2: a face should name vertices, not \"2a\"");
  expect("a.obj", "v 0 0 0\nf 1 1/x 1\n", "\"1/x\"");
  expect("a.obj", "f 99999999999999999999 1 1\n", "line 1");
  expect("a.obj", std::string("\0\1\2\3", 4), "not text");
  expect("a.off", "", "should begin with OFF");
  expect("a.off", "4OFF\n3 1 0\n", "should begin with OFF");
  expect("a.off", "OFF BINARY\n", "binary OFF is not supported");
  expect("a.off", "OFF\n-3 1 0\n", "whole number");
  expect("a.off", "OFF\n1 1 0\n0 0\n3 0 0 0\n", "line 3: vertex 0");
  expect("a.off", "OFF\n2 2 0\n0 0 0\n1 0 0\n3 0 1\n3 1 0 0\n", "line 5");
  expect("a.off", "OFF\n2 1 0\n0 0 0\n1 0 0\n3 0 1\n", "should name 3 vertices");
  expect("a.off", "OFF\n1 1 0\n0 0 0\n-1\n", "number of corners");
  expect("a.off", "OFF\n1 1 0\n0 0 0\n1 0\n1 0\n", "line 5");
  expect("a.ply", "plx\n", "begin with ply");
  expect("a.ply", "ply\nformat ascii 1.0\n", "no end_header");
  expect("a.ply", "ply\nend_header\n", "no format");
  expect("a.ply", "ply\nformat morse 1.0\n", "\"morse\"");
  expect("a.ply", "ply\nformat ascii 1.0\nelement vertex -1\n", "line 3");
  expect("a.ply", "ply\nformat ascii 1.0\nproperty int x\n", "should follow an element");
  expect("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty long x\n", "\"long\"");
  expect("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int x\n",
         "twice");
  expect("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nend_header\n1\n",
         "x, y and z");
  expect("a.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty int x\nend_header\n1\n",
         "vertex_indices");
  expect("a.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty list float int vertex_index\n",
         "integer");
  expect("a.ply", "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int x\n",
         "strips");
  expect("a.stl", "solid x\nfacet normal 0 0\nouter\n", "line 3: there should be a number");
  expect("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendsolid", "endloop");
  expect("a.stl", "garbage", "line 1");
}

// Counts larger than the file are refused before anything is allocated for them.
TEST_F(MeshReaderTest, ClaimsBeyondTheFileAreRefused) {
  for (const std::string counts : {"4000000000 1 0", "1 4000000000 0", "9000000000000000000 1 0"}) {
    ExpectError("a.off", "OFF\n" + counts + "\n0 0 0\n", Reason::kMalformedFile, "promises");
  }
  ExpectError("b.off", "OFF\n1 1 0\n0 0 0\n2000000000 0 0 0\n", Reason::kMalformedFile, "line");
  const std::string list = "property list int int vertex_index\nend_header\n";
  const std::string vertex =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  for (const std::string format : {"ascii", "binary_little_endian"}) {
    const std::string start = "ply\nformat " + format + " 1.0\n";
    ExpectError("a.ply", start + "element face 4000000000\n" + list, Reason::kMalformedFile,
                "promises");
    ExpectError("b.ply", start + "element face 1\n" + list + std::string("\xff\xff\xff\x7f", 4),
                Reason::kMalformedFile, "face 0");
    ExpectError("c.ply", start + "element empty 9000000000000000000\n" + vertex + "end_header\n",
                Reason::kMalformedFile, "promises");
    ExpectError("d.ply",
                start + "element skip 1\nproperty list uint double x\nend_header\n" +
                    std::string("\xff\xff\xff\xff\0\0\0\0", 8),
                Reason::kMalformedFile, "skip 0");
  }
  ExpectError("a.stl", std::string(80, 'x') + std::string("\xff\xff\xff\xff", 4),
              Reason::kMalformedFile, "4294967295 triangles");
}

}  // namespace
}  // namespace limn
