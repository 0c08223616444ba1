// SPDX-License-Identifier: MIT
// Conversion to OpenMesh and back loses nothing, and refuses what OpenMesh would assert on.
#include "engine/mesh/openmesh.h"

#include <gtest/gtest.h>

#include <limits>

#include "engine/mesh/generate.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

// OpenMesh's own view of the mesh agrees with the arrays, element by element.
void ExpectSameMesh(const OpenMeshPolyMesh& open, const PolygonMesh& mesh) {
  ASSERT_EQ(open.n_vertices(), mesh.vertex_count());
  ASSERT_EQ(open.n_faces(), mesh.face_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    const OpenMesh::Vec3d& p = open.point(OpenMesh::VertexHandle(static_cast<int>(v)));
    EXPECT_EQ((Vec3{p[0], p[1], p[2]}), mesh.positions[v]);
  }
  for (const auto face : open.faces()) {
    Buffer<Index> corners;
    for (const auto vertex : face.vertices()) corners.push_back(static_cast<Index>(vertex.idx()));
    EXPECT_EQ(absl::MakeConstSpan(corners), mesh.face(static_cast<std::size_t>(face.idx())));
  }
}

// The invariants of a half-edge mesh, in OpenMesh's terms.
void ExpectSound(const OpenMeshPolyMesh& open) {
  for (const auto h : open.halfedges()) {
    EXPECT_EQ(h.next().prev(), h);
    EXPECT_EQ(h.next().from(), h.to());
    EXPECT_EQ(h.next().face(), h.face());
    EXPECT_EQ(h.opp().to(), h.from());
  }
  for (const auto v : open.vertices()) {
    EXPECT_EQ(v.halfedge().from(), v);
    bool on_boundary = false;
    std::size_t around = 0;
    for (const auto h : v.outgoing_halfedges()) {
      on_boundary = on_boundary || h.is_boundary();
      ++around;
    }
    EXPECT_EQ(v.halfedge().is_boundary(), on_boundary);
    EXPECT_EQ(around, v.valence());
  }
}

TEST(OpenMeshTest, ClosedMeshesComeBackTheSame) {
  for (const std::string& name : oracle::ClosedMeshNames()) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = oracle::ClosedMesh(name);
    LIMN_ASSERT_OK_AND_ASSIGN(const OpenMeshPolyMesh open, ToOpenMesh(mesh));
    ExpectSameMesh(open, mesh);
    ExpectSound(open);
    EXPECT_EQ(FromOpenMesh(open), mesh);
  }
}

TEST(OpenMeshTest, OpenMeshesComeBackTheSame) {
  for (const MeshKind kind : {MeshKind::kGrid, MeshKind::kDisk}) {
    LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh, GenerateMesh({kind, 200, 3}));
    LIMN_ASSERT_OK_AND_ASSIGN(const OpenMeshPolyMesh open, ToOpenMesh(mesh));
    ExpectSameMesh(open, mesh);
    ExpectSound(open);
    EXPECT_EQ(FromOpenMesh(open), mesh);
  }
}

TEST(OpenMeshTest, MeshesBuiltByAddFaceAreReadInOrder) {
  OpenMeshPolyMesh open;
  std::vector<OpenMesh::VertexHandle> v;
  for (int i = 0; i < 5; ++i) {
    v.push_back(open.add_vertex(OpenMesh::Vec3d(i + 0.1, 1.0 / 3, -i)));
  }
  open.add_face({v[0], v[1], v[2], v[3]});
  open.add_face({v[4], v[2], v[1]});
  const PolygonMesh mesh = FromOpenMesh(open);
  ASSERT_EQ(mesh.vertex_count(), 5U);
  EXPECT_EQ(mesh.positions[4], (Vec3{4.1, 1.0 / 3, -4}));
  EXPECT_EQ(mesh.face(0), (Buffer<Index>{0, 1, 2, 3}));
  EXPECT_EQ(mesh.face(1), (Buffer<Index>{4, 2, 1}));
}

TEST(OpenMeshTest, DeletedElementsAreLeftOutAndTheRestCountedThrough) {
  LIMN_ASSERT_OK_AND_ASSIGN(OpenMeshPolyMesh open, ToOpenMesh(oracle::Cube()));
  open.request_vertex_status();
  open.request_edge_status();
  open.request_face_status();
  open.delete_vertex(OpenMesh::VertexHandle(0), /*delete isolated=*/false);
  const PolygonMesh mesh = FromOpenMesh(open);
  EXPECT_EQ(mesh.vertex_count(), 7U);
  EXPECT_EQ(mesh.face_count(), 3U);
  EXPECT_EQ(mesh.positions[0], oracle::Cube().positions[1]);
  EXPECT_TRUE(HalfEdgeMesh::Build(Context(), mesh).ok());
}

TEST(OpenMeshTest, ConvertedMeshesCanBeEditedByOpenMesh) {
  LIMN_ASSERT_OK_AND_ASSIGN(OpenMeshPolyMesh open, ToOpenMesh(oracle::Cube()));
  open.triangulate();
  EXPECT_EQ(open.n_faces(), 12U);
  EXPECT_TRUE(HalfEdgeMesh::Build(Context(), FromOpenMesh(open)).ok());
}

TEST(OpenMeshTest, BrokenMeshesNeverReachOpenMesh) {
  for (const oracle::BrokenMesh& broken : oracle::BrokenMeshes()) {
    SCOPED_TRACE(broken.name);
    const absl::Status status = ToOpenMesh(broken.mesh).status();
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(ReasonName(GetErrorDetail(status)->reason), ReasonName(broken.reason));
  }
}

TEST(OpenMeshTest, BadCoordinatesAreRefused) {
  PolygonMesh mesh = oracle::Cube();
  mesh.positions[4].y = std::numeric_limits<double>::infinity();
  oracle::ExpectError(ToOpenMesh(mesh).status(),
                      {Reason::kNonFiniteCoordinate, "mesh.vertices", 4});
}

TEST(OpenMeshTest, CancelledConversionStops) {
  const Context context;
  context.Cancel();
  EXPECT_EQ(ToOpenMesh(context, oracle::Cube()).status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace limn
