// SPDX-License-Identifier: MIT
// What repair refuses, what its options leave alone, how much time and memory it takes, and how it
// stops.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/mesh/generate.h"
#include "tests/engine/allocation_meter.h"
#include "tests/engine/repair_testing.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/slowdown.h"

namespace limn {
namespace {

using oracle::ExpectError;

absl::Status Refusal(const PolygonMesh& mesh, const Limits& limits = {}) {
  return Repair(Context(limits), mesh).status();
}

TEST(RepairLimits, RefusesCoordinatesThatArithmeticCannotTake) {
  PolygonMesh mesh = oracle::Cube();
  mesh.positions[5].y = std::nan("");
  ExpectError(Refusal(mesh), {Reason::kNonFiniteCoordinate, "mesh.vertices", 5});
  mesh.positions[5].y = 1e101;
  ExpectError(Refusal(mesh), {Reason::kCoordinateTooLarge, "mesh.vertices", 5});
  // Also of a vertex that would be removed.
  PolygonMesh isolated = oracle::Cube();
  isolated.positions.push_back({0, std::numeric_limits<double>::infinity(), 0});
  ExpectError(Refusal(isolated), {Reason::kNonFiniteCoordinate, "mesh.vertices", 8});
}

TEST(RepairLimits, RefusesIndicesThatAreNotThere) {
  PolygonMesh mesh = oracle::Cube();
  mesh.corner_vertex[9] = 8;
  ExpectError(Refusal(mesh), {Reason::kIndexOutOfRange, "mesh.faces", 2});
  // Also in a face that would be removed.
  PolygonMesh small = oracle::Cube();
  small.AddFace({1, kNoIndex});
  ExpectError(Refusal(small), {Reason::kIndexOutOfRange, "mesh.faces", 6});
}

TEST(RepairLimits, RefusesAritiesThatDoNotFitTheCorners) {
  std::vector<PolygonMesh> meshes(4, oracle::Cube());
  meshes[0].face_begin[2] = 3;
  meshes[1].face_begin.back() = 23;
  meshes[2].corner_vertex.resize(20);
  meshes[3].face_begin[0] = 1;
  for (const PolygonMesh& mesh : meshes) {
    ExpectError(Refusal(mesh), {Reason::kMalformedRequest, "mesh.faces"});
  }
}

TEST(RepairLimits, RefusesWhatIsEmptyOrWouldBe) {
  ExpectError(Refusal({}), {Reason::kEmptyMesh, "mesh.vertices"});
  ExpectError(Refusal(WithFaces(4, {})), {Reason::kEmptyMesh, "mesh.faces"});
  const absl::Status status = Refusal(WithFaces(4, {{0, 1}, {2, 3, 2, 3}, {}}));
  ExpectError(status, {Reason::kEmptyMesh, "mesh.faces"});
  EXPECT_NE(status.message().find("3 faces"), std::string_view::npos) << status;
}

TEST(RepairLimits, RefusesSizesAboveTheLimits) {
  const PolygonMesh cube = oracle::Cube();
  ExpectError(Refusal(cube, {.max_vertices = 7}), {Reason::kLimitExceeded, "mesh.vertices"});
  ExpectError(Refusal(cube, {.max_corners = 23}), {Reason::kLimitExceeded, "mesh.corners"});
  PolygonMesh many_empty;
  many_empty.positions = cube.positions;
  many_empty.face_begin.assign(26, 0);
  ExpectError(Refusal(many_empty, {.max_corners = 24}), {Reason::kLimitExceeded, "mesh.faces"});
  // Doubled vertices count.
  const PolygonMesh two = WithFaces(5, {{0, 1, 2}, {0, 3, 4}});
  ExpectError(Refusal(two, {.max_vertices = 5}), {Reason::kLimitExceeded, "mesh.vertices"});
  EXPECT_TRUE(Refusal(two, {.max_vertices = 6}).ok());
}

// One of every defect.
PolygonMesh EveryDefect() {
  return WithFaces(20, {{0, 1, 2},
                        {0, 1},        // degenerate
                        {2, 0, 1, 2},  // repeated, once mended
                        {3, 4, 5},
                        {3, 4, 6},  // turned
                        {7, 8, 9},
                        {8, 7, 10},
                        {7, 8, 11},  // a fin
                        {12, 13, 14},
                        {12, 15, 16}});  // two umbrellas
}

struct OptionCase {
  std::string name;
  bool RepairOptions::*option;
  Reason refused;
  // Numbers of the report that become 0.
  std::vector<std::uint64_t RepairReport::*> zeros;
};
void PrintTo(const OptionCase& c, std::ostream* out) { *out << c.name; }

class RepairOption : public testing::TestWithParam<OptionCase> {};

TEST_P(RepairOption, LeavesItsDefectAlone) {
  const RepairReport all = RepairOrDie(EveryDefect()).report;
  RepairOptions options;
  options.*GetParam().option = false;
  const RepairedMesh repaired = RepairOrDie(EveryDefect(), options);
  for (const auto number : GetParam().zeros) {
    EXPECT_EQ(repaired.report.*number, 0U);
    EXPECT_NE(all.*number, 0U);
  }
  const absl::Status status = HalfEdgeMesh::Build(Context(), repaired.mesh).status();
  if (GetParam().refused == Reason::kInternal) {
    EXPECT_TRUE(status.ok()) << status;
  } else {
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(ReasonName(GetErrorDetail(status)->reason), ReasonName(GetParam().refused)) << status;
  }
}

INSTANTIATE_TEST_SUITE_P(Options, RepairOption,
                         testing::Values(OptionCase{"DegenerateFaces",
                                                    &RepairOptions::degenerate_faces,
                                                    Reason::kFaceTooSmall,
                                                    {&RepairReport::degenerate_faces_removed,
                                                     &RepairReport::faces_mended}},
                                         // Repeated faces are turned or taken apart then.
                                         OptionCase{"RepeatedFaces",
                                                    &RepairOptions::repeated_faces,
                                                    Reason::kInternal,
                                                    {&RepairReport::repeated_faces_removed}},
                                         OptionCase{"Orientation",
                                                    &RepairOptions::orientation,
                                                    Reason::kInconsistentOrientation,
                                                    {&RepairReport::faces_reoriented}},
                                         OptionCase{"NonManifold",
                                                    &RepairOptions::non_manifold,
                                                    Reason::kNonManifoldEdge,
                                                    {&RepairReport::edges_split,
                                                     &RepairReport::vertices_split,
                                                     &RepairReport::vertices_added}},
                                         OptionCase{"IsolatedVertices",
                                                    &RepairOptions::isolated_vertices,
                                                    Reason::kIsolatedVertex,
                                                    {&RepairReport::isolated_vertices_removed}}),
                         [](const auto& test) { return test.param.name; });

TEST(RepairLimits, WithoutRepairOfDegenerateFacesTheyComeOutAsTheyWentIn) {
  const Faces faces = {{0, 1}, {3, 4, 3, 5}, {}, {6, 7, 8}};
  const RepairedMesh repaired =
      RepairOrDie(WithFaces(9, faces), {.degenerate_faces = false, .isolated_vertices = false});
  EXPECT_EQ(repaired.mesh, WithFaces(9, faces));
  EXPECT_EQ(repaired.report, RepairReport());
}

TEST(RepairLimits, EveryDefectIsInTheReport) {
  const RepairReport report = Checked(EveryDefect()).report;
  EXPECT_EQ(report.degenerate_faces_removed, 1U);
  EXPECT_EQ(report.faces_mended, 1U);
  EXPECT_EQ(report.repeated_faces_removed, 1U);
  EXPECT_EQ(report.faces_reoriented, 1U);
  EXPECT_EQ(report.edges_split, 1U);
  EXPECT_EQ(report.vertices_split, 3U);
  EXPECT_EQ(report.vertices_added, 3U);
  EXPECT_EQ(report.isolated_vertices_removed, 3U);
}

TEST(RepairLimits, RepairedVerticesAreThoseThatKeptTheirPlace) {
  const RepairedMesh repaired = RepairOrDie(WithFaces(9, {{1, 2, 3}, {5, 6, 7}, {1, 5, 8}}));
  // 0 and 4 are removed; 1 and 5 are kept by the first faces, their copies come last.
  EXPECT_EQ(repaired.original_vertex, (Buffer<Index>{1, 2, 3, 5, 6, 7, 8, 1, 5}));
  EXPECT_EQ(repaired.kept_vertices, 7U);
  EXPECT_EQ(RepairedVertices(repaired, {8, 0, 1, 5, 4, 1, 9, kNoIndex}),
            (Buffer<Index>{6, kNoIndex, 0, 3, kNoIndex, 0, kNoIndex, kNoIndex}));
  EXPECT_TRUE(RepairedVertices(repaired, {}).empty());
}

TEST(RepairLimits, MendsExactlyWhatItSays) {
  for (const Reason reason :
       {Reason::kFaceTooSmall, Reason::kRepeatedVertex, Reason::kIsolatedVertex,
        Reason::kNonManifoldEdge, Reason::kInconsistentOrientation, Reason::kNonManifoldVertex}) {
    EXPECT_TRUE(RepairMends(reason));
  }
  for (const Reason reason : {Reason::kEmptyMesh, Reason::kIndexOutOfRange,
                              Reason::kNonFiniteCoordinate, Reason::kMalformedRequest}) {
    EXPECT_FALSE(RepairMends(reason));
  }
}

// Large meshes with many defects of one kind, by name.

constexpr Index kMany = 100'000 / oracle::kSlowdown;

PolygonMesh Book(bool alternating) {
  PolygonMesh mesh = WithFaces(kMany + 2, {});
  for (Index i = 0; i < kMany; ++i) {
    const Index a = alternating ? i % 2 : 0;
    mesh.AddFace({a, 1 - a, 2 + i});
  }
  return mesh;
}

std::vector<std::pair<std::string, PolygonMesh>> LargeMeshes() {
  std::vector<std::pair<std::string, PolygonMesh>> meshes;
  meshes.emplace_back("an edge of single faces", Book(false));
  meshes.emplace_back("an edge of pairs", Book(true));
  PolygonMesh umbrellas = WithFaces(2 * kMany + 1, {});
  for (Index i = 0; i < kMany; ++i) umbrellas.AddFace({2 * i + 1, 2 * i + 2, 0});
  meshes.emplace_back("a vertex of umbrellas", umbrellas);
  // Closed: two wedges per edge of the ring, all at the edge (0, 1).
  PolygonMesh wedges = WithFaces(2 * kMany + 2, {});
  for (Index i = 0; i < kMany; ++i) {
    const Index a = 2 + 2 * i;
    for (const auto& face : Faces{{0, 1, a}, {1, 0, a + 1}, {0, a, a + 1}, {a, 1, a + 1}}) {
      wedges.AddFace(face);
    }
  }
  meshes.emplace_back("an edge of tetrahedra", wedges);
  PolygonMesh repeated = WithFaces(kMany + 2, {});
  for (Index i = 0; i < kMany; ++i) repeated.AddFace({0, 1, 2 + i % 5});
  meshes.emplace_back("repeated faces", repeated);
  std::vector<Index> walk(kMany);
  for (Index i = 0; i < kMany; ++i) walk[i] = i;
  PolygonMesh long_faces = WithFaces(kMany, {walk, {walk.rbegin(), walk.rend()}, walk});
  walk.insert(walk.end(), walk.rbegin(), walk.rend());
  long_faces.AddFace(walk);
  for (Index& v : walk) v = v / 3 * (v % 3);
  long_faces.AddFace(walk);
  meshes.emplace_back("long faces", long_faces);
  PolygonMesh hub = oracle::DoublePyramid(kMany);
  for (std::size_t f = 0; f < hub.face_count(); f += 3) {
    std::swap(hub.corner_vertex[3 * f], hub.corner_vertex[3 * f + 1]);
  }
  meshes.emplace_back("a hub of turned faces", hub);
  std::mt19937_64 random(8);
  for (const Index vertices : {200, 3000}) {
    PolygonMesh soup = WithFaces(vertices, {});
    for (Index i = 0; i < kMany; ++i) {
      soup.AddFace({static_cast<Index>(random() % vertices),
                    static_cast<Index>(random() % vertices),
                    static_cast<Index>(random() % vertices)});
    }
    meshes.emplace_back(absl::StrCat("a soup of ", vertices), soup);
  }
  return meshes;
}

TEST(RepairLarge, TakesLinearithmicTimeHoweverManyFacesMeet) {
  for (const auto& [name, mesh] : LargeMeshes()) {
    SCOPED_TRACE(name);
    const auto begin = Context::Clock::now();
    const RepairedMesh repaired = RepairOrDie(mesh);
    // All pairs of a hundred thousand would be minutes; a tenth of a second is usual.
    EXPECT_LT(Context::Clock::now() - begin, std::chrono::seconds(3));
    const auto built = HalfEdgeMesh::Build(Context(), repaired.mesh);
    EXPECT_TRUE(built.ok()) << built.status();
  }
}

TEST(RepairLarge, BooksAndWedgesComeApartAsTheyShould) {
  EXPECT_EQ(RepairOrDie(Book(false)).mesh.vertex_count(), 3 * kMany);
  // Up and down in turn: each pair shares the edge.
  EXPECT_EQ(RepairOrDie(Book(true)).mesh.vertex_count(), 2 * kMany);
  for (const auto& [name, mesh] : LargeMeshes()) {
    if (name != "an edge of tetrahedra") continue;
    const RepairedMesh repaired = RepairOrDie(mesh);
    EXPECT_EQ(repaired.mesh.vertex_count(), 4 * kMany);
    EXPECT_EQ(HalfEdgeMesh::Build(Context(), repaired.mesh)->boundary_edge_count(), 0U);
  }
}

TEST(RepairLarge, IsTheSameForAnyNumberOfThreads) {
  for (const auto& [name, mesh] : LargeMeshes()) {
    SCOPED_TRACE(name);
    const RepairedMesh one = oracle::WithThreads(1, [&, &m = mesh] { return RepairOrDie(m); });
    for (const int threads : {2, 5}) {
      const RepairedMesh many =
          oracle::WithThreads(threads, [&, &m = mesh] { return RepairOrDie(m); });
      EXPECT_EQ(many.mesh, one.mesh);
      EXPECT_EQ(many.original_vertex, one.original_vertex);
      EXPECT_EQ(many.original_face, one.original_face);
      EXPECT_EQ(many.report, one.report);
    }
  }
}

TEST(RepairLarge, EstimateIsAnUpperBoundOfWhatTheWorstMeshNeeds) {
  double largest = 0;
  for (const auto& [name, mesh] : LargeMeshes()) {
    SCOPED_TRACE(name);
    const std::uint64_t estimate =
        EstimateRepairBytes(mesh.vertex_count(), mesh.face_count(), mesh.corner_count());
    const AllocationMeter meter;
    const RepairedMesh repaired = RepairOrDie(mesh);
    EXPECT_LE(meter.peak(), estimate);
    largest = std::max(largest, static_cast<double>(meter.peak()) / static_cast<double>(estimate));
  }
  // And not far above it.
  EXPECT_GT(largest, 0.5);
  EXPECT_EQ(EstimateRepairBytes(~0ULL, ~0ULL, ~0ULL), std::numeric_limits<std::uint64_t>::max());
}

TEST(RepairLimits, StoppedJobsDoNotStart) {
  const Context cancelled;
  cancelled.Cancel();
  ExpectError(Repair(cancelled, EveryDefect()).status(), {Reason::kCancelled});
  Context late;
  late.set_deadline(Context::Clock::now());
  ExpectError(Repair(late, EveryDefect()).status(), {Reason::kDeadlineExceeded});
}

TEST(RepairLarge, EndsWhereverItIsCancelled) {
  for (const auto& [name, mesh] : LargeMeshes()) {
    SCOPED_TRACE(name);
    std::vector<double> fractions;
    Context listening;
    listening.set_progress([&](const ProgressEvent& event) {
      EXPECT_EQ(event.stage, "repair");
      fractions.push_back(event.fraction);
    });
    ASSERT_TRUE(Repair(listening, mesh).ok());
    ASSERT_GE(fractions.size(), 3U);
    EXPECT_EQ(fractions.front(), 0);
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    for (const double fraction : fractions) {
      Context context;
      double last = 0;
      context.set_progress([&](const ProgressEvent& event) {
        last = event.fraction;
        if (event.fraction == fraction) context.Cancel();
      });
      ExpectError(Repair(context, mesh).status(), {Reason::kCancelled});
      EXPECT_EQ(last, fraction);
    }
  }
}

}  // namespace
}  // namespace limn
