// SPDX-License-Identifier: MIT
#include "engine/mesh/half_edge_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/repair.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/tessellation.h"

namespace limn {
namespace {

using oracle::BuildOrDie;
using oracle::ExpectError;

void ExpectSame(const HalfEdgeMesh& a, const HalfEdgeMesh& b) {
  EXPECT_EQ(a.vertex(), b.vertex());
  EXPECT_EQ(a.twin(), b.twin());
  EXPECT_EQ(a.edge(), b.edge());
  EXPECT_EQ(a.edge_half_edge(), b.edge_half_edge());
  EXPECT_EQ(a.vertex_half_edge(), b.vertex_half_edge());
  EXPECT_EQ(a.face_begin(), b.face_begin());
  EXPECT_EQ(a.face(), b.face());
  EXPECT_EQ(a.fan_begin(), b.fan_begin());
  EXPECT_EQ(a.fan(), b.fan());
}

// What a half-edge mesh must be, checked against maps of the faces' directed sides.
class Invariants {
 public:
  explicit Invariants(const PolygonMesh& mesh)
      : mesh_(mesh), built_(BuildOrDie(mesh)), walk_(built_) {
    for (std::size_t f = 0; f < mesh.face_count(); ++f) {
      for (Index h = mesh.face_begin[f]; h < mesh.face_begin[f + 1]; ++h) {
        const Index next = h + 1 == mesh.face_begin[f + 1] ? mesh.face_begin[f] : h + 1;
        next_.push_back(next);
        face_.push_back(static_cast<Index>(f));
        side_[{mesh.corner_vertex[h], mesh.corner_vertex[next]}] = h;
      }
    }
  }

  void Check() const {
    ASSERT_EQ(built_.vertex_count(), mesh_.vertex_count());
    ASSERT_EQ(built_.face_count(), mesh_.face_count());
    ASSERT_EQ(built_.half_edge_count(), mesh_.corner_count());
    EXPECT_EQ(built_.arity(), 0U);
    CornersKeepTheirOrder();
    TwinsRunTheOtherWay();
    EdgesAreNumberedByFirstOccurrence();
    FansAreCounterClockwiseAndWhole();
  }

 private:
  void CornersKeepTheirOrder() const {
    EXPECT_EQ(built_.vertex(), absl::MakeConstSpan(mesh_.corner_vertex));
    EXPECT_EQ(built_.face_begin(), absl::MakeConstSpan(mesh_.face_begin));
    EXPECT_EQ(built_.face(), absl::MakeConstSpan(face_));
    for (Index h = 0; h < built_.half_edge_count(); ++h) {
      ASSERT_EQ(walk_.Next(h), next_[h]);
      ASSERT_EQ(walk_.Prev(next_[h]), h);
    }
  }

  void TwinsRunTheOtherWay() const {
    std::size_t boundary = 0;
    for (Index h = 0; h < built_.half_edge_count(); ++h) {
      const auto twin = side_.find({mesh_.corner_vertex[next_[h]], mesh_.corner_vertex[h]});
      ASSERT_EQ(built_.twin()[h], twin == side_.end() ? kNoIndex : twin->second) << h;
      boundary += twin == side_.end() ? 1 : 0;
    }
    EXPECT_EQ(built_.boundary_edge_count(), boundary);
  }

  void EdgesAreNumberedByFirstOccurrence() const {
    const oracle::EdgeNumbers numbers = oracle::NumberEdges(oracle::FromPolygonMesh(mesh_).faces);
    ASSERT_EQ(built_.edge_count(), numbers.size());
    std::vector<Index> first(numbers.size(), kNoIndex);
    for (Index h = 0; h < built_.half_edge_count(); ++h) {
      const auto key = oracle::EdgeKey(static_cast<int>(mesh_.corner_vertex[h]),
                                       static_cast<int>(mesh_.corner_vertex[next_[h]]));
      const auto edge = static_cast<Index>(numbers.at(key));
      ASSERT_EQ(built_.edge()[h], edge);
      first[edge] = std::min(first[edge], h);
    }
    EXPECT_EQ(built_.edge_half_edge(), absl::MakeConstSpan(first));
  }

  void FansAreCounterClockwiseAndWhole() const {
    std::vector<int> seen(built_.half_edge_count(), 0);
    ASSERT_EQ(built_.fan_begin().front(), 0U);
    ASSERT_EQ(built_.fan_begin().back(), built_.half_edge_count());
    for (Index v = 0; v < built_.vertex_count(); ++v) {
      const auto fan = built_.fan().subspan(built_.fan_begin()[v], built_.valence(v));
      ASSERT_FALSE(fan.empty());
      ASSERT_EQ(fan.front(), built_.vertex_half_edge()[v]);
      for (std::size_t i = 0; i < fan.size(); ++i) {
        ASSERT_EQ(mesh_.corner_vertex[fan[i]], v);
        ++seen[fan[i]];
        const Index after = oracle_ccw(fan[i]);
        // A fan that ends at a boundary starts at one too.
        const bool last = i + 1 == fan.size();
        const bool open = built_.twin()[fan.front()] == kNoIndex;
        ASSERT_EQ(after, !last ? fan[i + 1] : open ? kNoIndex : fan.front());
      }
    }
    EXPECT_EQ(seen, std::vector<int>(seen.size(), 1));
  }

  // The half-edge across the one that enters h's vertex.
  Index oracle_ccw(Index h) const {
    const auto prev = static_cast<Index>(std::find(next_.begin(), next_.end(), h) - next_.begin());
    const auto across = side_.find({mesh_.corner_vertex[h], mesh_.corner_vertex[prev]});
    return across == side_.end() ? kNoIndex : across->second;
  }

  const PolygonMesh& mesh_;
  const HalfEdgeMesh built_;
  const PolygonWalk walk_;
  std::vector<Index> next_;
  std::vector<Index> face_;
  std::map<std::pair<Index, Index>, Index> side_;
};

class HalfEdgeMeshTest : public oracle::ClosedMeshTest {};

TEST_P(HalfEdgeMeshTest, HoldsItsInvariants) { Invariants(mesh_).Check(); }

TEST_P(HalfEdgeMeshTest, ClosedMeshesHaveNoBoundary) {
  const HalfEdgeMesh built = BuildOrDie(mesh_);
  EXPECT_EQ(built.boundary_edge_count(), 0U);
  EXPECT_EQ(std::count(built.twin().begin(), built.twin().end(), kNoIndex), 0);
}

TEST_P(HalfEdgeMeshTest, OpenMeshesHoldTheInvariantsToo) {
  // Without its first face, unless that leaves vertices alone.
  PolygonMesh open;
  open.positions = mesh_.positions;
  for (std::size_t f = 1; f < mesh_.face_count(); ++f) open.AddFace(mesh_.face(f));
  ASSERT_LT(open.face_count(), mesh_.face_count());
  Invariants(open).Check();
}

LIMN_FOR_CLOSED_MESHES(HalfEdgeMeshTest);

TEST(HalfEdgeMesh, BuildsTheOpenKinds) {
  for (const MeshKind kind : {MeshKind::kGrid, MeshKind::kDisk}) {
    LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh mesh,
                              GenerateMesh({.kind = kind, .vertices = 200}));
    Invariants(mesh).Check();
  }
}

TEST(HalfEdgeMesh, IsTheSameForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh irregular,
                            GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 30000}));
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh open,
                            GenerateMesh({.kind = MeshKind::kDisk, .vertices = 30000}));
  for (const PolygonMesh& mesh :
       {oracle::Shuffled(irregular, 11), open, oracle::DoublePyramid(20000)}) {
    const HalfEdgeMesh one = oracle::WithThreads(1, [&] { return BuildOrDie(mesh); });
    for (const int threads : {2, 5}) {
      ExpectSame(one, oracle::WithThreads(threads, [&] { return BuildOrDie(mesh); }));
    }
  }
}

TEST(HalfEdgeMesh, TakesAHubOfValence20000InLinearithmicTime) {
  const PolygonMesh mesh = oracle::DoublePyramid(20000);
  const auto begin = Context::Clock::now();
  const HalfEdgeMesh built = BuildOrDie(mesh);
  const auto elapsed = Context::Clock::now() - begin;
  EXPECT_EQ(built.valence(0), 20000U);
  // A search through the hub for each of its half-edges would be 4e8 steps; milliseconds are usual.
  EXPECT_LT(elapsed, std::chrono::seconds(1));
  for (Index h = 0; h < built.half_edge_count(); ++h) {
    ASSERT_EQ(built.twin()[built.twin()[h]], h);
  }
}

TEST(HalfEdgeMesh, RefusesManyFacesAtOneEdgeWithoutPairingThemAll) {
  PolygonMesh mesh;
  constexpr Index kFaces = 200000;
  mesh.positions.resize(kFaces + 2);
  for (Index i = 0; i < kFaces; ++i) mesh.AddFace({0, 1, 2 + i});
  const auto begin = Context::Clock::now();
  ExpectError(HalfEdgeMesh::Build(Context(), mesh).status(),
              {Reason::kNonManifoldEdge, "mesh.faces", 0});
  // All pairs would take minutes.
  EXPECT_LT(Context::Clock::now() - begin, std::chrono::seconds(5));
}

TEST(HalfEdgeMesh, NamesKindCountAndFirstElementOfWhatItRefuses) {
  for (const oracle::BrokenMesh& broken : oracle::BrokenMeshes()) {
    for (const int threads : {1, 2}) {
      SCOPED_TRACE(absl::StrCat(broken.name, ", threads: ", threads));
      const absl::Status status = oracle::WithThreads(
          threads, [&] { return HalfEdgeMesh::Build(Context(), broken.mesh).status(); });
      ExpectError(status, {broken.reason, broken.field, broken.first});
      const bool faces = broken.field == "mesh.faces";
      const std::string first = absl::StrCat(faces ? "face " : "vertex ", broken.first);
      EXPECT_NE(status.message().find(first), std::string_view::npos) << status;
      EXPECT_NE(status.message().find(absl::StrCat(": ", broken.count, " ")),
                std::string_view::npos)
          << status;
      // And says so when repair would help.
      EXPECT_EQ(status.message().find("repair") != std::string_view::npos,
                RepairMends(broken.reason))
          << status;
    }
  }
}

TEST(HalfEdgeMesh, NamesTheFirstOfManyInEveryBlock) {
  LIMN_ASSERT_OK_AND_ASSIGN(PolygonMesh mesh,
                            GenerateMesh({.kind = MeshKind::kTorus, .vertices = 40000}));
  for (const std::size_t f : {39000, 20000, 30000}) {
    mesh.corner_vertex[mesh.face_begin[f]] = mesh.corner_vertex[mesh.face_begin[f] + 1];
  }
  const absl::Status status =
      oracle::WithThreads(4, [&] { return HalfEdgeMesh::Build(Context(), mesh).status(); });
  ExpectError(status, {Reason::kRepeatedVertex, "mesh.faces", 20000});
  EXPECT_NE(status.message().find(": 3 faces"), std::string_view::npos) << status;
}

TEST(HalfEdgeMesh, RefusesEmptyMeshes) {
  PolygonMesh no_vertices = oracle::Cube();
  no_vertices.positions.clear();
  PolygonMesh no_faces;
  no_faces.positions = oracle::Cube().positions;
  PolygonMesh no_faces_but_begin = no_faces;
  no_faces_but_begin.face_begin.push_back(0);
  const auto build = [](const PolygonMesh& mesh) {
    return HalfEdgeMesh::Build(Context(), mesh).status();
  };
  ExpectError(build({}), {Reason::kEmptyMesh, "mesh.vertices"});
  ExpectError(build(no_vertices), {Reason::kEmptyMesh, "mesh.vertices"});
  ExpectError(build(no_faces), {Reason::kEmptyMesh, "mesh.faces"});
  ExpectError(build(no_faces_but_begin), {Reason::kEmptyMesh, "mesh.faces"});
}

TEST(HalfEdgeMesh, RefusesAritiesThatDoNotFitTheCorners) {
  std::vector<PolygonMesh> meshes(5, oracle::Cube());
  meshes[0].face_begin[2] = 3;             // decreasing
  meshes[1].face_begin.back() = 23;        // corners left over
  meshes[2].corner_vertex.resize(20);      // corners missing
  meshes[3].face_begin[0] = 1;             // first corner skipped
  meshes[4].face_begin[3] = kNoIndex - 1;  // far out
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectError(HalfEdgeMesh::Build(Context(), meshes[i]).status(),
                {Reason::kMalformedRequest, "mesh.faces"});
  }
}

TEST(HalfEdgeMesh, RefusesSizesAboveTheLimits) {
  const PolygonMesh cube = oracle::Cube();
  Limits limits;
  limits.max_vertices = 7;
  ExpectError(HalfEdgeMesh::Build(Context(limits), cube).status(),
              {Reason::kLimitExceeded, "mesh.vertices"});
  limits.max_vertices = 8;
  limits.max_corners = 23;
  ExpectError(HalfEdgeMesh::Build(Context(limits), cube).status(),
              {Reason::kLimitExceeded, "mesh.corners"});
  limits.max_corners = 24;
  EXPECT_TRUE(HalfEdgeMesh::Build(Context(limits), cube).ok());
}

TEST(HalfEdgeMesh, EndsWhenTheJobIsCancelledOrLate) {
  const Context cancelled;
  cancelled.Cancel();
  ExpectError(HalfEdgeMesh::Build(cancelled, oracle::Cube()).status(), {Reason::kCancelled});
  Context late;
  late.set_deadline(Context::Clock::now());
  ExpectError(HalfEdgeMesh::Build(late, oracle::Cube()).status(), {Reason::kDeadlineExceeded});
}

TEST(HalfEdgeMesh, DoesNotLookAtPositions) {
  PolygonMesh mesh = oracle::Cube();
  for (Vec3& p : mesh.positions) p = {0, std::nan(""), 1e308};
  ExpectSame(BuildOrDie(mesh), BuildOrDie(oracle::Cube()));
}

}  // namespace
}  // namespace limn
