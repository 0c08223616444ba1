// SPDX-License-Identifier: MIT
// What repair leaves alone and what it makes of each kind of defect.
#include "engine/mesh/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/mesh/generate.h"
#include "tests/engine/repair_testing.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::BoundarySides;

// A mesh that Build accepts comes back as it was, bit for bit.

class RepairClosedMesh : public oracle::ClosedMeshTest {};

TEST_P(RepairClosedMesh, ComesBackAsItWas) { ExpectUntouched(mesh_); }

TEST_P(RepairClosedMesh, ComesBackAsItWasWithoutSomeFaces) {
  std::mt19937_64 random(17);
  PolygonMesh open;
  open.positions = mesh_.positions;
  for (std::size_t f = 0; f < mesh_.face_count(); ++f) {
    if (random() % 5 != 0) open.AddFace(mesh_.face(f));
  }
  if (HalfEdgeMesh::Build(Context(), open).ok()) {
    ExpectUntouched(open);
  } else if (open.face_count() > 0) {
    // What lost faces at a vertex is repaired, and then left alone.
    ExpectUntouched(Checked(open).mesh);
  }
}

LIMN_FOR_CLOSED_MESHES(RepairClosedMesh);

TEST(Repair, LeavesOpenMeshesAlone) {
  for (const MeshKind kind : {MeshKind::kGrid, MeshKind::kDisk}) {
    LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                              GenerateMesh({.kind = kind, .vertices = 20000}));
    ExpectUntouched(mesh);
  }
}

TEST(Repair, KeepsTheBitsOfPositions) {
  PolygonMesh mesh = oracle::Cube();
  mesh.positions[3] = {-0.0, 5e-324, 1e100};
  mesh.AddFace({0, 1, 1});
  const RepairedMesh repaired = Checked(mesh);
  EXPECT_TRUE(std::signbit(repaired.mesh.positions[3].x));
  EXPECT_EQ(repaired.mesh.positions[3].y, 5e-324);
}

// Every mesh that Build refuses for what repair mends becomes one that it accepts.
TEST(Repair, MendsWhatBuildRefuses) {
  int mended = 0;
  for (const oracle::BrokenMesh& broken : oracle::BrokenMeshes()) {
    SCOPED_TRACE(broken.name);
    if (!RepairMends(broken.reason)) {
      oracle::ExpectError(Repair(Context(), broken.mesh).status(),
                          {broken.reason, broken.field, broken.first});
      continue;
    }
    const RepairedMesh repaired = Checked(broken.mesh);
    EXPECT_NE(repaired.report, RepairReport());
    ++mended;
  }
  EXPECT_GE(mended, 10);
}

// Step 1.

TEST(Repair, CutsFacesIntoSimplePolygonsWhereTheyVisitAVertexAgain) {
  struct Case {
    std::vector<Index> face;
    Faces polygons;
  };
  const Case cases[] = {
      {{}, {}},
      {{4}, {}},
      {{4, 5}, {}},
      {{4, 4, 4, 4}, {}},
      {{4, 5, 4}, {}},
      {{4, 5, 5}, {}},
      {{4, 5, 6, 5}, {}},
      {{4, 5, 4, 5, 4, 5}, {}},
      {{4, 5, 6, 7}, {{4, 5, 6, 7}}},
      {{4, 5, 5, 6}, {{4, 5, 6}}},
      {{4, 4, 5, 6}, {{4, 5, 6}}},
      {{4, 5, 6, 4}, {{4, 5, 6}}},
      {{4, 5, 6, 6, 6, 4, 4}, {{4, 5, 6}}},
      // A spike.
      {{4, 5, 6, 7, 6}, {{4, 5, 6}}},
      {{4, 5, 6, 7, 8, 7, 6}, {{4, 5, 6}}},
      // Two polygons that meet in a vertex, and one within the walk of another.
      {{4, 5, 6, 4, 7, 8}, {{4, 5, 6}, {4, 7, 8}}},
      {{4, 5, 6, 7, 5, 8}, {{5, 6, 7}, {4, 5, 8}}},
      // One polygon twice around.
      {{4, 5, 6, 4, 5, 6}, {{4, 5, 6}}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::PrintToString(c.face));
    // Beside a face that stays whatever happens.
    const PolygonMesh mesh = WithFaces(9, {{0, 1, 2}, c.face, {3, 1, 0}});
    const RepairedMesh repaired = Checked(mesh);
    Faces expected = {{0, 1, 2}};
    expected.insert(expected.end(), c.polygons.begin(), c.polygons.end());
    expected.push_back({3, 1, 0});
    Faces found = FacesOf(repaired.mesh);
    for (auto& face : found) {
      for (Index& v : face) v = repaired.original_vertex[v];
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(repaired.original_face.front(), 0U);
    EXPECT_EQ(repaired.original_face.back(), 2U);
  }
}

// Step 2.

TEST(Repair, RemovesRepeatedFacesHoweverTheyAreWritten) {
  std::vector<Index> face = {0, 1, 2, 3, 4};
  Faces faces = {face, {0, 5, 1}};
  for (int turn = 0; turn < 5; ++turn) {
    std::rotate(face.begin(), face.begin() + 1, face.end());
    faces.push_back(face);
    faces.emplace_back(face.rbegin(), face.rend());
  }
  // Not repeated: the same vertices in another order, and more or fewer of them.
  faces.push_back({0, 2, 1, 3, 4});
  faces.push_back({0, 1, 2, 3});
  const RepairedMesh repaired = Checked(WithFaces(6, faces));
  EXPECT_EQ(repaired.report.repeated_faces_removed, 10U);
  EXPECT_EQ(repaired.original_face, (Buffer<Index>{0, 1, 12, 13}));
}

TEST(Repair, TwoFacesBackToBackAreASoundSurface) {
  ExpectUntouched(WithFaces(3, {{0, 1, 2}, {2, 1, 0}}));
  ExpectUntouched(WithFaces(8, {{0, 1, 2, 3}, {2, 1, 0, 3}, {4, 5, 6, 7}, {5, 4, 7, 6}}));
  // The same way round they are one face given twice.
  EXPECT_EQ(Checked(WithFaces(3, {{0, 1, 2}, {1, 2, 0}})).mesh.face_count(), 1U);
  // With a third face at one of their edges too, and so is one of three.
  EXPECT_EQ(Checked(WithFaces(4, {{0, 1, 2}, {2, 1, 0}, {0, 1, 3}})).mesh.face_count(), 2U);
  EXPECT_EQ(Checked(WithFaces(3, {{0, 1, 2}, {2, 1, 0}, {0, 1, 2}})).mesh.face_count(), 1U);
}

TEST(Repair, DoubleSidedMeshesBecomeSingleSided) {
  for (const std::string name : {"torus_of_triangles", "dodecahedron", "genus_three"}) {
    const PolygonMesh single = oracle::ClosedMesh(name);
    PolygonMesh both = single;
    for (std::size_t f = 0; f < single.face_count(); ++f) {
      std::vector<Index> face(single.face(f).begin(), single.face(f).end());
      std::reverse(face.begin(), face.end());
      both.AddFace(face);
    }
    EXPECT_EQ(RepairOrDie(both).mesh, single) << name;
  }
}

// The surfaces of all cubes, the walls between them given by both, with common vertices.
PolygonMesh EachCube(const std::set<std::array<int, 3>>& cubes) {
  PolygonMesh mesh;
  std::map<std::array<double, 3>, Index> numbers;
  for (const auto& cube : cubes) {
    const PolygonMesh one = oracle::CubesSurface({cube});
    for (auto face : FacesOf(one)) {
      for (Index& v : face) {
        const Vec3& p = one.positions[v];
        const auto [at, fresh] =
            numbers.emplace(std::array{p.x, p.y, p.z}, static_cast<Index>(numbers.size()));
        if (fresh) mesh.positions.push_back(p);
        v = at->second;
      }
      mesh.AddFace(face);
    }
  }
  return mesh;
}

TEST(Repair, WallsBetweenSolidsVanish) {
  std::set<std::array<int, 3>> block;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < 3; ++z) block.insert({x, y, z});
    }
  }
  for (const auto& cubes : {std::set<std::array<int, 3>>{{0, 0, 0}, {1, 0, 0}}, block}) {
    const PolygonMesh hull = oracle::CubesSurface(cubes);
    const RepairedMesh repaired = Checked(EachCube(cubes));
    EXPECT_EQ(repaired.mesh.face_count(), hull.face_count());
    EXPECT_EQ(repaired.mesh.vertex_count(), hull.vertex_count());
    EXPECT_EQ(BoundarySides(repaired.mesh), 0U);
    EXPECT_EQ(repaired.report.repeated_faces_removed, repaired.report.folded_faces_removed);
    EXPECT_EQ(repaired.report.edges_split, 0U);
  }
}

TEST(Repair, FoldsVanishWhereTheyHangOnASurface) {
  const PolygonMesh cube = oracle::Cube();
  const Index a = cube.corner_vertex[0];
  const Index b = cube.corner_vertex[1];
  // A fold of four faces on an edge, two one way round and two the other.
  PolygonMesh fold = cube;
  fold.positions.push_back({7, 8, 9});
  fold.positions.push_back({9, 9, 9});
  for (const auto& face : Faces{{a, b, 8}, {a, 8, 9}, {8, b, a}, {9, 8, a}}) fold.AddFace(face);
  const RepairedMesh repaired = Checked(fold);
  EXPECT_EQ(repaired.mesh, cube);
  EXPECT_EQ(repaired.report.repeated_faces_removed, 2U);
  EXPECT_EQ(repaired.report.folded_faces_removed, 2U);
  EXPECT_EQ(repaired.report.isolated_vertices_removed, 2U);
  EXPECT_EQ(RepairOrDie(fold, {.folds = false}).mesh.face_count(), 8U);

  // Given once more one way round, the first face is none of a fold, and holds the other.
  PolygonMesh fin = fold;
  fin.AddFace({a, b, 8});
  EXPECT_EQ(Checked(fin).report.folded_faces_removed, 0U);
  // A face of the cube itself, given again backwards, is not missed on one side only.
  PolygonMesh twice = cube;
  twice.AddFace({cube.corner_vertex[2], b, a, cube.corner_vertex[3]});
  EXPECT_EQ(Checked(twice).mesh, cube);
}

// Step 3.

TEST(Repair, MajorityOrientationOfEachComponentWins) {
  std::mt19937_64 random(5);
  for (const std::string& name : oracle::ClosedMeshNames()) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = oracle::ClosedMesh(name);
    PolygonMesh turned;
    turned.positions = mesh.positions;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      std::vector<Index> face(mesh.face(f).begin(), mesh.face(f).end());
      // Of pillows, which have two faces, none.
      if (mesh.face_count() > 2 && random() % 5 == 0) std::reverse(face.begin() + 1, face.end());
      turned.AddFace(face);
    }
    const RepairedMesh repaired = Checked(turned);
    EXPECT_EQ(repaired.report.edges_cut, 0U);
    EXPECT_EQ(repaired.mesh.vertex_count(), mesh.vertex_count());
    EXPECT_EQ(repaired.mesh, mesh);
  }
}

TEST(Repair, OfAsManyFacesOfEitherOrientationTheFirstWins) {
  const RepairedMesh repaired = Checked(WithFaces(8, {{0, 1, 2}, {0, 1, 3}, {4, 5, 7}, {4, 5, 6}}));
  EXPECT_EQ(FacesOf(repaired.mesh), (Faces{{0, 1, 2}, {0, 3, 1}, {4, 5, 7}, {4, 6, 5}}));
  EXPECT_EQ(repaired.report.faces_reoriented, 2U);
}

// Quads around a ring of that many; the last one joins the first turned over.
PolygonMesh Moebius(int n) {
  Faces faces;
  for (Index i = 0; i + 1 < static_cast<Index>(n); ++i) {
    faces.push_back({2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2});
  }
  const auto last = static_cast<Index>(2 * n - 2);
  faces.push_back({last, last + 1, 0, 1});
  return WithFaces(static_cast<std::size_t>(2 * n), faces);
}

TEST(Repair, MoebiusStripIsCutOpenOnce) {
  for (const int n : {3, 4, 5, 40}) {
    SCOPED_TRACE(n);
    const RepairedMesh repaired = Checked(Moebius(n));
    EXPECT_EQ(repaired.report.edges_cut, 1U);
    EXPECT_EQ(repaired.report.vertices_added, 2U);
    EXPECT_EQ(repaired.report.faces_split_off, 0U);
    EXPECT_EQ(repaired.mesh.face_count(), static_cast<std::size_t>(n));
  }
}

TEST(Repair, ClosedSurfacesWithoutOrientationAreCutOpen) {
  // The projective plane of six vertices: half an icosahedron.
  const PolygonMesh plane = WithFaces(6, {{0, 1, 2},
                                          {0, 2, 3},
                                          {0, 3, 4},
                                          {0, 4, 5},
                                          {0, 5, 1},
                                          {1, 2, 4},
                                          {2, 3, 5},
                                          {3, 4, 1},
                                          {4, 5, 2},
                                          {5, 1, 3}});
  EXPECT_EQ(BoundarySides(plane), 0U);
  EXPECT_GT(Checked(plane).report.edges_cut, 0U);
  // A Klein bottle: a grid whose rows close, and whose columns close turned over.
  for (const Index n : {4, 7}) {
    Faces faces;
    const auto at = [n](Index i, Index j) { return i < n ? i * n + j % n : (2 * n - j) % n; };
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) {
        faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
    const PolygonMesh bottle = WithFaces(n * n, faces);
    EXPECT_EQ(BoundarySides(bottle), 0U);
    const RepairedMesh repaired = Checked(bottle);
    EXPECT_GT(repaired.report.edges_cut, 0U);
    EXPECT_EQ(repaired.mesh.face_count(), n * n);
  }
}

// Step 4.

TEST(Repair, FinsFallOffASurface) {
  for (const std::string name :
       {"cube", "dodecahedron", "torus_of_triangles", "double_pyramid_200"}) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = oracle::ClosedMesh(name);
    // Given before the surface, and pointing either way.
    for (const bool up : {false, true}) {
      PolygonMesh with_fin;
      with_fin.positions = mesh.positions;
      const auto tip = static_cast<Index>(mesh.vertex_count());
      with_fin.positions.push_back({9, 9, 9});
      const Index a = mesh.corner_vertex[up ? 0 : 1];
      const Index b = mesh.corner_vertex[up ? 1 : 0];
      with_fin.AddFace({a, b, tip});
      for (std::size_t f = 0; f < mesh.face_count(); ++f) with_fin.AddFace(mesh.face(f));
      const RepairedMesh repaired = Checked(with_fin);
      // The fin comes first and keeps its vertices; the surface has copies, and is whole.
      EXPECT_EQ(repaired.report.edges_split, 1U);
      EXPECT_EQ(repaired.report.vertices_added, 2U);
      EXPECT_EQ(BoundarySides(repaired.mesh), 3U);
    }
  }
}

TEST(Repair, SurfacesThatTouchAreLetGoOfEachOther) {
  struct Case {
    std::string name;
    std::set<std::array<int, 3>> cubes;
    std::uint64_t edges;
    std::uint64_t added;
  };
  const Case cases[] = {
      {"at a vertex", {{0, 0, 0}, {1, 1, 1}}, 0, 1},
      {"at an edge", {{0, 0, 0}, {1, 1, 0}}, 1, 2},
      {"at a row of edges",
       {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {1, 1, 0}, {1, 1, 1}, {1, 1, 2}},
       3,
       4},
      {"with itself at an edge",
       {{0, 0, 0}, {1, 1, 0}, {0, 0, 1}, {1, 1, 1}, {1, 0, 1}, {0, 1, -1}, {0, 0, -1}, {1, 1, -1}},
       1,
       2},
      {"all over", {{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}}, 6, 9},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const RepairedMesh repaired = Checked(oracle::CubesSurface(c.cubes));
    EXPECT_EQ(repaired.report.edges_split, c.edges);
    EXPECT_EQ(repaired.report.faces_split_off, 0U);
    EXPECT_EQ(BoundarySides(repaired.mesh), 0U);
    EXPECT_EQ(repaired.report.vertices_added, c.added);
  }
}

TEST(Repair, LargerComponentsArePairedFirst) {
  // Two tetrahedra that share a face: the hull stays closed, the wall falls out.
  const PolygonMesh joined =
      WithFaces(5, {{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}, {0, 1, 4}, {1, 2, 4}, {2, 0, 4}});
  const RepairedMesh repaired = Checked(joined);
  EXPECT_EQ(repaired.report.edges_split, 3U);
  EXPECT_EQ(BoundarySides(repaired.mesh), 3U);
  EXPECT_EQ(repaired.report.vertices_added, 3U);
  EXPECT_EQ(repaired.mesh.face(0)[0], 0U);
}

}  // namespace
}  // namespace limn
