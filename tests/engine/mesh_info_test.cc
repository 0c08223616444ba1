// SPDX-License-Identifier: MIT
// DescribeMesh tells of sound meshes what they are and of broken ones what Build would say.
#include "engine/mesh/mesh_info.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/oracle/expect.h"

namespace limn {
namespace {

using Histogram = std::map<std::uint64_t, std::uint64_t>;

const MeshProblem* Find(const MeshInfo& info, Reason reason) {
  for (const MeshProblem& problem : info.problems) {
    if (problem.reason == reason) return &problem;
  }
  return nullptr;
}

TEST(MeshInfoTest, CubeHasTheNumbersOfACube) {
  const MeshInfo info = DescribeMesh(oracle::Cube());
  EXPECT_EQ(info.vertices, 8U);
  EXPECT_EQ(info.faces, 6U);
  EXPECT_EQ(info.corners, 24U);
  EXPECT_EQ(info.edges, 12U);
  EXPECT_EQ(info.arities, (Histogram{{4, 6}}));
  EXPECT_EQ(info.valences, (Histogram{{3, 8}}));
  EXPECT_TRUE(info.closed());
  EXPECT_EQ(info.boundary_loops, 0U);
  EXPECT_EQ(info.components, 1U);
  EXPECT_EQ(info.euler_characteristic, 2);
  EXPECT_EQ(info.genus, 0);
  EXPECT_TRUE(info.problems.empty());
}

TEST(MeshInfoTest, ComponentsAndHandlesAreCounted) {
  EXPECT_EQ(DescribeMesh(oracle::TwoComponents()).components, 2U);
  EXPECT_EQ(DescribeMesh(oracle::TwoComponents()).genus, 0);
  EXPECT_EQ(DescribeMesh(oracle::TorusOfQuads(5, 4)).genus, 1);
  EXPECT_EQ(DescribeMesh(oracle::GenusThree()).genus, 3);
}

TEST(MeshInfoTest, BoundaryLoopsAreCountedAndFilledForTheGenus) {
  PolygonMesh torus = oracle::TorusOfQuads(8, 8);
  // Two faces that are no neighbours make way.
  PolygonMesh open;
  open.positions = torus.positions;
  for (std::size_t f = 0; f < torus.face_count(); ++f) {
    if (f != 0 && f != 35) open.AddFace(torus.face(f));
  }
  const MeshInfo info = DescribeMesh(open);
  EXPECT_FALSE(info.closed());
  EXPECT_EQ(info.boundary_edges, 8U);
  EXPECT_EQ(info.boundary_loops, 2U);
  EXPECT_EQ(info.euler_characteristic, -2);
  EXPECT_EQ(info.genus, 1);
  EXPECT_TRUE(info.problems.empty());
}

TEST(MeshInfoTest, BoxIsThatOfTheFinitePoints) {
  PolygonMesh mesh = oracle::Cube();
  mesh.positions[3] = {7, -8, 9};
  mesh.positions[5].x = std::numeric_limits<double>::quiet_NaN();
  mesh.positions[6].x = -1e101;
  const MeshInfo info = DescribeMesh(mesh);
  EXPECT_EQ(info.box.min.x, -1e101);
  EXPECT_EQ(info.box.min.y, -8);
  EXPECT_EQ(info.box.max.x, 7);
  EXPECT_EQ(info.box.max.z, 9);
  ASSERT_NE(Find(info, Reason::kNonFiniteCoordinate), nullptr);
  EXPECT_EQ(Find(info, Reason::kNonFiniteCoordinate)->first, 5U);
  ASSERT_NE(Find(info, Reason::kCoordinateTooLarge), nullptr);
  EXPECT_EQ(Find(info, Reason::kCoordinateTooLarge)->first, 6U);
}

TEST(MeshInfoTest, BrokenMeshesHaveTheProblemThatBuildNames) {
  for (const oracle::BrokenMesh& broken : oracle::BrokenMeshes()) {
    SCOPED_TRACE(broken.name);
    const MeshInfo info = DescribeMesh(broken.mesh);
    ASSERT_FALSE(info.problems.empty());
    EXPECT_EQ(ReasonName(info.problems.front().reason), ReasonName(broken.reason))
        << info.problems.front().text;
    const MeshProblem* problem = Find(info, broken.reason);
    ASSERT_NE(problem, nullptr);
    EXPECT_NE(problem->text, "");
    if (broken.reason == Reason::kEmptyMesh || broken.reason == Reason::kMalformedRequest) continue;
    EXPECT_EQ(problem->count, broken.count) << problem->text;
    EXPECT_EQ(problem->first, broken.first) << problem->text;
  }
}

TEST(MeshInfoTest, SeveralProblemsAreAllListed) {
  PolygonMesh mesh = oracle::MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {5, 5, 5}},
                                      {{0, 1, 2}, {0, 1, 3}, {0, 1}, {2, 2, 3}, {0, 1, 9}});
  const MeshInfo info = DescribeMesh(mesh);
  EXPECT_EQ(info.arities, (Histogram{{2, 1}, {3, 4}}));
  EXPECT_EQ(info.genus, std::nullopt);
  for (const Reason reason : {Reason::kFaceTooSmall, Reason::kIndexOutOfRange,
                              Reason::kRepeatedVertex, Reason::kIsolatedVertex}) {
    EXPECT_NE(Find(info, reason), nullptr) << ReasonName(reason);
  }
  EXPECT_EQ(Find(info, Reason::kIsolatedVertex)->first, 4U);
}

TEST(MeshInfoTest, ClosedMeshesAreWithoutProblemsAndMatchTheHalfEdgeMesh) {
  for (const std::string& name : oracle::ClosedMeshNames()) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = oracle::ClosedMesh(name);
    const MeshInfo info = DescribeMesh(mesh);
    const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
    EXPECT_TRUE(info.problems.empty());
    EXPECT_EQ(info.edges, built.edge_count());
    EXPECT_EQ(info.boundary_edges, 0U);
    Histogram valences;
    for (std::size_t v = 0; v < mesh.vertex_count(); ++v) ++valences[built.valence(v)];
    EXPECT_EQ(info.valences, valences);
    ASSERT_TRUE(info.genus.has_value());
    EXPECT_EQ(info.euler_characteristic,
              2 * static_cast<std::int64_t>(info.components) - 2 * *info.genus);
  }
}

// Any arrays at all: no crash, and the problem list is empty exactly when Build accepts.
TEST(MeshInfoTest, AgreesWithBuildOnRandomArrays) {
  constexpr std::uint64_t kSeed = 4242;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  int accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    PolygonMesh mesh;
    mesh.positions.resize(1 + random() % 6, Vec3{0, 0, 0});
    mesh.face_begin.push_back(0);
    for (std::uint64_t faces = random() % 5; faces > 0; --faces) {
      for (std::uint64_t corners = 2 + random() % 3; corners > 0; --corners) {
        mesh.corner_vertex.push_back(static_cast<Index>(random() % (mesh.vertex_count() + 1) %
                                                        (random() % 8 == 0 ? 99 : 6)));
      }
      mesh.face_begin.push_back(static_cast<Index>(mesh.corner_count()));
    }
    if (random() % 50 == 0) mesh.face_begin[random() % mesh.face_begin.size()] += 1;
    const absl::Status status = HalfEdgeMesh::Build(Context(), mesh).status();
    const MeshInfo info = DescribeMesh(mesh);
    EXPECT_EQ(info.problems.empty(), status.ok()) << status << " round " << round;
    if (!status.ok() && !info.problems.empty()) {
      EXPECT_EQ(ReasonName(info.problems.front().reason),
                ReasonName(GetErrorDetail(status)->reason))
          << status << " but " << info.problems.front().text << " round " << round;
    }
    accepted += status.ok() ? 1 : 0;
  }
  EXPECT_GT(accepted, 20);
}

}  // namespace
}  // namespace limn
