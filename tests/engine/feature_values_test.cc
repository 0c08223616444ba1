// SPDX-License-Identifier: MIT
// Feature values by element and by face: which one counts, and what is refused.
#include "engine/constraints/feature_values.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <ostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/features.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(FeatureTable, HasTheDefaultsWithoutEntries) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Cube());
  LIMN_ASSERT_OK_AND_ASSIGN(const FeatureTable table, MakeFeatureTable(Context{}, mesh, {}));
  EXPECT_EQ(table.edge, Buffer<double>(24, 0.5));
  EXPECT_EQ(table.vertex, Buffer<double>(24, 1.0));
  EXPECT_TRUE(table.plane.empty());
}

// Random entries of all kinds, in any order, against a search through the lists.
TEST(FeatureTable, TheEntryThatSaysMostCounts) {
  constexpr std::uint64_t kSeed = 71;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  const auto chance = [&] { return random() % 3 == 0; };
  const auto value = [&] { return static_cast<double>(random() % 1001) / 1000; };
  for (const PolygonMesh& polygons :
       {oracle::ClosedMesh("genus_three"), oracle::DoublePyramid(9), oracle::QuadPatch(4, 3)}) {
    const HalfEdgeMesh mesh = oracle::BuildOrDie(polygons);
    const PolygonWalk walk(mesh);
    FeatureValues values = {.default_edge = value(), .default_vertex = value()};
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
      const Index v = mesh.vertex()[h];
      const Index next = mesh.vertex()[walk.Next(h)];
      const Index face = mesh.face()[h];
      if (chance()) values.edges.push_back({next, v, face, value()});
      if (mesh.edge_half_edge()[mesh.edge()[h]] == h && chance()) {
        values.edges.push_back({v, next, std::nullopt, value()});
      }
      if (chance()) values.vertices.push_back({v, face, value()});
      if (mesh.vertex_half_edge()[v] == h && chance()) {
        values.vertices.push_back({v, std::nullopt, value()});
      }
    }
    std::shuffle(values.edges.begin(), values.edges.end(), random);
    std::shuffle(values.vertices.begin(), values.vertices.end(), random);
    LIMN_ASSERT_OK_AND_ASSIGN(const FeatureTable table, MakeFeatureTable(Context{}, mesh, values));
    for (Index h = 0; h < mesh.half_edge_count(); ++h) {
      const int v = static_cast<int>(mesh.vertex()[h]);
      const int next = static_cast<int>(mesh.vertex()[walk.Next(h)]);
      const int face = static_cast<int>(mesh.face()[h]);
      ASSERT_EQ(table.edge[h], static_cast<double>(oracle::EdgeValueOf(values, face, v, next)));
      ASSERT_EQ(table.vertex[h], static_cast<double>(oracle::VertexValueOf(values, face, v)));
    }
  }
}

TEST(FeatureTable, FacesArePlaneByDefaultOrByName) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Cube());
  const auto planes = [&](const FeatureValues& values) {
    auto table = MakeFeatureTable(Context{}, mesh, values);
    EXPECT_TRUE(table.ok()) << table.status();
    std::vector<int> plane;
    for (std::size_t f = 0; f < 6; ++f) plane.push_back(table->IsPlane(f) ? 1 : 0);
    return plane;
  };
  EXPECT_EQ(planes({.faces = {{2, FaceKind::kPlane}, {3, FaceKind::kSurface}}}),
            (std::vector<int>{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(planes({.default_face = FaceKind::kPlane, .faces = {{1, FaceKind::kSurface}}}),
            (std::vector<int>{1, 0, 1, 1, 1, 1}));
  FeatureValues none = {.default_face = FaceKind::kPlane};
  for (Index f = 0; f < 6; ++f) none.faces.push_back({f, FaceKind::kSurface});
  auto table = MakeFeatureTable(Context{}, mesh, none);
  ASSERT_TRUE(table.ok());
  EXPECT_TRUE(table->plane.empty());
}

struct BadValues {
  std::string name;
  FeatureValues values;
  Reason reason;
  std::string field;
  std::optional<std::uint64_t> index;
  std::string words;
};
void PrintTo(const BadValues& bad, std::ostream* out) { *out << bad.name; }

class BadFeatureValues : public testing::TestWithParam<BadValues> {};

TEST_P(BadFeatureValues, AreRefusedByFieldAndIndex) {
  const BadValues& bad = GetParam();
  // Face 0 of the cube has vertices 0 to 3.
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Cube());
  const absl::Status status = MakeFeatureTable(Context{}, mesh, bad.values).status();
  const std::string path = "constraints.features." + bad.field;
  oracle::ExpectError(status, {bad.reason, path, bad.index});
  const std::string message(status.message());
  EXPECT_TRUE(message.starts_with(path + ": ")) << message;
  EXPECT_NE(message.find(bad.words), std::string::npos) << message;
}

// Two vertices of the cube that no edge joins, and a face without vertex 0.
std::pair<Index, Index> Apart() {
  const PolygonMesh cube = oracle::Cube();
  return {cube.face(0)[0], cube.face(0)[2]};
}
Index FaceWithout(Index v) {
  const PolygonMesh cube = oracle::Cube();
  Index f = 0;
  while (std::count(cube.face(f).begin(), cube.face(f).end(), v) > 0) ++f;
  return f;
}

std::vector<BadValues> AllBadValues() {
  const PolygonMesh cube = oracle::Cube();
  const Index a = cube.face(0)[0];
  const Index b = cube.face(0)[1];
  const auto [p, q] = Apart();
  const Index other = FaceWithout(a);
  constexpr Reason kOption = Reason::kInvalidOption;
  constexpr Reason kRange = Reason::kIndexOutOfRange;
  return {
      {"default_edge", {.default_edge = 1.5}, kOption, "default_edge", {}, "1.5"},
      {"default_edge_nan", {.default_edge = kNan}, kOption, "default_edge", {}, "nan"},
      {"default_vertex", {.default_vertex = -0.1}, kOption, "default_vertex", {}, "-0.1"},
      {"face", {.faces = {{6, FaceKind::kPlane}}}, kRange, "faces[0].face", 0, "no face 6"},
      {"face_twice",
       {.faces = {{2, FaceKind::kPlane}, {1, FaceKind::kPlane}, {2, FaceKind::kSurface}}},
       kOption,
       "faces[2].face",
       2,
       "face 2 is named before"},
      {"edge_from", {.edges = {{8, a, {}, 0.5}}}, kRange, "edges[0].from", 0, "no vertex 8"},
      {"edge_to", {.edges = {{a, b, {}, 0.5}, {a, 99, {}, 0.5}}}, kRange, "edges[1].to", 1, "99"},
      {"edge_face", {.edges = {{a, b, 6, 0.5}}}, kRange, "edges[0].face", 0, "no face 6"},
      {"edge_value", {.edges = {{a, b, {}, 2}}}, kOption, "edges[0].value", 0, "from 0 to 1"},
      {"edge_value_nan", {.edges = {{a, b, {}, kNan}}}, kOption, "edges[0].value", 0, "nan"},
      {"no_edge", {.edges = {{p, q, {}, 0.5}}}, kOption, "edges[0].to", 0, "no edge joins"},
      {"no_edge_to_itself", {.edges = {{a, a, {}, 0.5}}}, kOption, "edges[0].to", 0, "no edge"},
      {"edge_not_in_face", {.edges = {{a, b, other, 0.5}}}, kOption, "edges[0].face", 0, "not in"},
      {"edge_twice",
       {.edges = {{a, b, {}, 0.5}, {b, a, {}, 0.5}}},
       kOption,
       "edges[1].from",
       1,
       "named before"},
      {"edge_twice_in_face",
       {.edges = {{a, b, 0, 0.5}, {a, b, {}, 1}, {b, a, 0, 0.5}}},
       kOption,
       "edges[2].face",
       2,
       "named before"},
      {"vertex", {.vertices = {{8, {}, 0.5}}}, kRange, "vertices[0].vertex", 0, "no vertex 8"},
      {"vertex_face", {.vertices = {{a, 6, 0.5}}}, kRange, "vertices[0].face", 0, "no face 6"},
      {"vertex_value", {.vertices = {{a, {}, -1}}}, kOption, "vertices[0].value", 0, "-1"},
      {"vertex_not_in_face",
       {.vertices = {{a, other, 0.5}}},
       kOption,
       "vertices[0].face",
       0,
       "not in face"},
      {"vertex_twice",
       {.vertices = {{a, {}, 0.5}, {b, {}, 0.5}, {a, {}, 0.5}}},
       kOption,
       "vertices[2].vertex",
       2,
       "named before"},
      {"vertex_twice_in_face",
       {.vertices = {{a, 0, 0.5}, {a, 0, 0.5}}},
       kOption,
       "vertices[1].face",
       1,
       "named before"},
  };
}

INSTANTIATE_TEST_SUITE_P(All, BadFeatureValues, testing::ValuesIn(AllBadValues()),
                         [](const auto& bad) { return bad.param.name; });

TEST(FeatureTable, StopsWhenCancelled) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Cube());
  const Context context;
  context.Cancel();
  EXPECT_EQ(MakeFeatureTable(context, mesh, {}).status().code(), absl::StatusCode::kCancelled);
}

// Naming all edges of a hub costs no more than its corners.
TEST(FeatureTable, AHubIsLookedUpInTime) {
  constexpr int kRim = 100'000;
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::DoublePyramid(kRim));
  const PolygonWalk walk(mesh);
  FeatureValues values;
  for (const Index h : mesh.edge_half_edge()) {
    values.edges.push_back({mesh.vertex()[h], mesh.vertex()[walk.Next(h)], mesh.face()[h], 0.1});
  }
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    values.vertices.push_back({mesh.vertex()[h], mesh.face()[h], 0.2});
  }
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_TRUE(MakeFeatureTable(Context{}, mesh, values).ok());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

}  // namespace
}  // namespace limn
