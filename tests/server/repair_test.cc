// SPDX-License-Identifier: MIT
// Repair on request: the job is that of the repaired mesh, and the answer says what was changed.
#include "engine/mesh/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "engine/interpolate.h"
#include "proto/wire/repair_mapping.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

// A sphere with a face turned, one repeated, one of two corners, a vertex of two fans and one of
// none. Closed once it is repaired.
PolygonMesh BrokenSphere(std::uint64_t vertices) {
  const PolygonMesh sphere = MakeSphere(vertices);
  const PolygonMesh other = MakeSphere(40, 2);
  PolygonMesh broken;
  broken.positions = sphere.positions;
  broken.positions.push_back({5, 5, 5});
  // The second sphere hangs on the first one's vertex 3 by its vertex 0.
  const auto first = static_cast<Index>(broken.vertex_count() - 1);
  for (std::size_t v = 1; v < other.vertex_count(); ++v) {
    broken.positions.push_back(other.positions[v] + Vec3{9, 0, 0});
  }
  for (std::size_t f = 0; f < sphere.face_count(); ++f) {
    std::vector<Index> face(sphere.face(f).begin(), sphere.face(f).end());
    if (f == 7) std::reverse(face.begin(), face.end());
    broken.AddFace(face);
    if (f == 9) broken.AddFace(face);
    if (f == 11) broken.AddFace({face[0], face[1]});
  }
  for (std::size_t f = 0; f < other.face_count(); ++f) {
    std::vector<Index> face(other.face(f).begin(), other.face(f).end());
    for (Index& v : face) v = v == 0 ? 3 : first + v;
    broken.AddFace(face);
  }
  return broken;
}

v1::InterpolateHeader RepairHeader(std::uint32_t level) {
  v1::InterpolateHeader header = MakeHeader(level);
  header.mutable_output()->set_repair(true);
  return header;
}

TEST(ServiceRepairTest, GivesWhatTheEngineGivesForTheRepairedMesh) {
  const PolygonMesh broken = BrokenSphere(500);
  const absl::StatusOr<RepairedMesh> repaired = Repair(Context(), broken);
  ASSERT_TRUE(repaired.ok()) << repaired.status();
  const auto computed = Interpolate(Context(), repaired->mesh, {.level = 1});
  ASSERT_TRUE(computed.ok()) << computed.status();

  const std::unique_ptr<Server> server = StartServer();
  const absl::StatusOr<JobResult> result =
      Client(server->InProcessChannel()).Run(RepairHeader(1), broken);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->control_mesh.positions, computed->control_positions);
  EXPECT_EQ(result->control_mesh.corner_vertex, repaired->mesh.corner_vertex);
  EXPECT_EQ(result->surface.positions, computed->surface.positions);

  const v1::Summary& summary = result->summary;
  EXPECT_EQ(summary.input_vertices(), broken.vertex_count());
  EXPECT_EQ(summary.input_faces(), broken.face_count());
  EXPECT_EQ(summary.certificate().points_checked(), repaired->mesh.vertex_count());
  ASSERT_GT(summary.stages_size(), 3);
  EXPECT_EQ(summary.stages(2).stage(), "decode");
  EXPECT_EQ(summary.stages(3).stage(), "repair");
  const v1::RepairReport& report = summary.repair();
  EXPECT_EQ(report.degenerate_faces_removed(), 1U);
  EXPECT_EQ(report.repeated_faces_removed(), 1U);
  EXPECT_EQ(report.faces_reoriented(), 1U);
  EXPECT_EQ(report.vertices_split(), 1U);
  EXPECT_EQ(report.vertices_added(), 1U);
  EXPECT_EQ(report.isolated_vertices_removed(), 1U);
  EXPECT_EQ(wire::MappingElements(report.original_vertex()), repaired->original_vertex);
  EXPECT_EQ(wire::MappingElements(report.original_face()), repaired->original_face);
}

TEST(ServiceRepairTest, TheMappingComesInBoundedPiecesBeforeTheControlMesh) {
  const PolygonMesh broken = BrokenSphere(5000);
  const RepairedMesh repaired = *Repair(Context(), broken);
  v1::InterpolateHeader header = RepairHeader(0);
  constexpr std::uint32_t kTileBytes = 4 << 10;
  header.mutable_output()->set_tile_bytes(kTileBytes);
  // Packed by hand: the fixture's upload is that of a sound mesh.
  header.mutable_mesh()->set_encoding(v1::MESH_ENCODING_PACKED);
  const std::unique_ptr<Server> server = StartServer();
  const Client client(server->InProcessChannel());
  auto job = client.Submit(header, broken);
  ASSERT_TRUE(job.ok()) << job.status();
  std::string order;
  std::string vertices;
  std::string faces;
  std::uint64_t bytes = 0;
  v1::Summary summary;
  while (const auto message = job->Next()) {
    char kind = '-';
    if (message->has_repair()) {
      kind = 'R';
      EXPECT_LE(message->repair().ByteSizeLong(), kTileBytes + 16);
      EXPECT_NE(message->repair().original_vertex().empty(),
                message->repair().original_face().empty());
      vertices += message->repair().original_vertex();
      faces += message->repair().original_face();
    }
    if (message->has_control_mesh()) {
      kind = 'C';
      bytes += message->control_mesh().chunk().data().size();
    }
    if (message->has_tile()) {
      kind = 'T';
      bytes += message->tile().positions().size() + message->tile().normals().size() +
               message->tile().face_vertices().size() + message->tile().arities().size();
    }
    if (message->has_summary()) summary = message->summary();
    if (kind != '-' && (order.empty() || order.back() != kind)) order += kind;
  }
  ASSERT_TRUE(job->Finish().ok()) << job->Finish();
  EXPECT_EQ(order, "RCT");
  EXPECT_EQ(wire::MappingElements(vertices), repaired.original_vertex);
  EXPECT_EQ(wire::MappingElements(faces), repaired.original_face);
  EXPECT_EQ(summary.bytes_sent(), bytes + vertices.size() + faces.size());
  EXPECT_TRUE(summary.repair().original_vertex().empty());
}

TEST(ServiceRepairTest, ASoundMeshIsUntouchedAndHasNoMapping) {
  const PolygonMesh sphere = MakeSphere(300);
  const std::unique_ptr<Server> server = StartServer();
  const Client client(server->InProcessChannel());
  const auto with = client.Run(RepairHeader(2), sphere);
  const auto without = client.Run(MakeHeader(2), sphere);
  ASSERT_TRUE(with.ok() && without.ok()) << with.status() << without.status();
  EXPECT_EQ(with->control_mesh, without->control_mesh);
  EXPECT_EQ(with->surface.positions, without->surface.positions);
  EXPECT_TRUE(with->summary.has_repair());
  EXPECT_EQ(with->summary.repair().ByteSizeLong(), 0U);
  EXPECT_FALSE(without->summary.has_repair());
}

TEST(ServiceRepairTest, WithoutItTheRefusalNamesIt) {
  PolygonMesh broken = MakeSphere(100);
  broken.positions.push_back({9, 9, 9});
  const std::unique_ptr<Server> server = StartServer();
  const absl::Status status =
      Client(server->InProcessChannel()).Run(MakeHeader(1), broken).status();
  EXPECT_EQ(ReasonOf(status), Reason::kIsolatedVertex);
  EXPECT_NE(status.message().find("--repair"), std::string_view::npos) << status;
}

TEST(ServiceRepairTest, AMeshThatIsOpenAfterRepairIsInterpolated) {
  // With a face to remove before the hole.
  const PolygonMesh sphere = MakeSphere(100);
  PolygonMesh open;
  open.positions = sphere.positions;
  open.AddFace({0, 1});
  for (std::size_t f = 1; f < sphere.face_count(); ++f) open.AddFace(sphere.face(f));
  const std::unique_ptr<Server> server = StartServer();
  const auto result = Client(server->InProcessChannel()).Run(RepairHeader(1), open);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.repair().degenerate_faces_removed(), 1U);
  EXPECT_LE(result->summary.certificate().max_error(),
            1e-12 * result->summary.certificate().bounding_box_diagonal());
}

// Constraints name the vertices that were sent, not those that repair made of them.
TEST(ServiceRepairTest, ConstraintsFollowTheirVertices) {
  PolygonMesh broken = MakeSphere(100);
  broken.positions.insert(broken.positions.begin(), Vec3{9, 9, 9});
  for (Index& v : broken.corner_vertex) ++v;
  const std::unique_ptr<Server> server = StartServer();
  v1::InterpolateHeader header = RepairHeader(1);
  header.mutable_constraints()->mutable_interpolate()->add_vertices(100);
  v1::NormalConstraint& normal = *header.mutable_constraints()->add_normals();
  normal.set_vertex(100);
  normal.mutable_normal()->set_x(1);
  const auto result = Client(server->InProcessChannel()).Run(header, broken);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.certificate().points_checked(), 1U);
  EXPECT_LE(result->summary.certificate().max_error(), 1e-12);
  EXPECT_LE(result->summary.certificate().max_normal_deviation(), 1e-6);
  EXPECT_EQ(result->summary.input_vertices(), 101U);
  header.mutable_constraints()->mutable_interpolate()->set_vertices(0, 0);
  header.mutable_constraints()->clear_normals();
  const absl::Status left_out = Client(server->InProcessChannel()).Run(header, broken).status();
  EXPECT_EQ(GetErrorDetail(left_out)->field, "constraints.interpolate.vertices[0]");
}

TEST(ServiceRepairTest, WhatCannotBeRepairedKeepsItsError) {
  PolygonMesh broken = BrokenSphere(100);
  broken.positions[7].y = 1e101;
  const std::unique_ptr<Server> server = StartServer();
  const absl::Status status =
      Client(server->InProcessChannel()).Run(RepairHeader(1), broken).status();
  EXPECT_EQ(ReasonOf(status), Reason::kCoordinateTooLarge);
  EXPECT_EQ(GetErrorDetail(status)->index, 7U);
}

}  // namespace
}  // namespace limn
