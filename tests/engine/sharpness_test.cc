// SPDX-License-Identifier: MIT
#include "engine/scheme/sharpness.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/generate.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "tests/oracle/creases.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/open_meshes.h"

namespace limn {
namespace {

using oracle::CreasedMesh;
using oracle::Creases;
using oracle::Rule;

Sharpness MakeOrDie(const HalfEdgeMesh& mesh, const Creases& creases) {
  auto made = MakeSharpness(Context(), mesh, creases.input());
  EXPECT_TRUE(made.ok()) << made.status();
  return *std::move(made);
}

// The values, with those that stand for empty arrays.
void ExpectEqual(const Sharpness& sharpness, const CreasedMesh& expected) {
  const oracle::Incidence incidence = oracle::IncidenceOf(expected);
  for (std::size_t e = 0; e < expected.edges.size(); ++e) {
    const bool boundary = incidence.faces_of_edge[e].size() == 1;
    const float found = sharpness.creased() ? sharpness.edge[e] : (boundary ? kSharpForever : 0);
    ASSERT_EQ(found, oracle::SharpnessOf(expected, incidence, static_cast<int>(e))) << e;
  }
  for (std::size_t v = 0; v < expected.points.size(); ++v) {
    const bool corner = sharpness.boundary == BoundaryRule::kEdgeAndCorner &&
                        incidence.faces_of_vertex[v].size() == 1;
    const float found = sharpness.creased() ? sharpness.vertex[v] : (corner ? kSharpForever : 0);
    ASSERT_EQ(found, expected.vertex_sharpness[v]) << v;
  }
  for (std::size_t f = 0; f < expected.faces.size(); ++f) {
    ASSERT_EQ(!sharpness.hole.empty() && sharpness.hole[f] != 0, expected.hole[f]) << f;
  }
}

void ExpectTheOraclesLevels(const PolygonMesh& given, const Creases& creases, Rule rule) {
  const Context context;
  HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  Sharpness sharpness = MakeOrDie(mesh, creases);
  CreasedMesh expected = oracle::WithCreases(oracle::FromPolygonMesh(given), creases);
  ExpectEqual(sharpness, expected);
  for (int level = 1; level <= 4 && expected.faces.size() < 6000; ++level) {
    SCOPED_TRACE(level);
    LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, rule == Rule::kLoop
                                                            ? SplitIntoTriangles(context, mesh)
                                                            : SplitIntoQuads(context, mesh));
    LIMN_ASSERT_OK_AND_ASSIGN(sharpness, RefineSharpness(context, mesh, split, sharpness));
    mesh = split;
    expected = oracle::RefineCreased(expected, rule);
    ExpectEqual(sharpness, expected);
  }
}

class SharpnessTest : public testing::TestWithParam<std::string> {
 protected:
  static PolygonMesh Given() {
    const std::string& name = GetParam();
    for (const std::string& open : oracle::OpenMeshNames()) {
      if (open == name) return oracle::OpenMesh(name);
    }
    return oracle::ClosedMesh(name);
  }
};

TEST_P(SharpnessTest, IsTheOraclesAtEveryLevel) {
  const PolygonMesh quads = Given();
  const PolygonMesh triangles = oracle::Triangulated(quads);
  for (const BoundaryRule boundary : {BoundaryRule::kEdgeOnly, BoundaryRule::kEdgeAndCorner}) {
    for (const std::uint64_t seed : {1, 2}) {
      SCOPED_TRACE(seed);
      Creases creases = oracle::RandomCreases(quads, seed);
      creases.boundary = boundary;
      ExpectTheOraclesLevels(quads, creases, Rule::kCatmullClark);
      creases = oracle::RandomCreases(triangles, seed);
      creases.boundary = boundary;
      ExpectTheOraclesLevels(triangles, creases, Rule::kLoop);
    }
  }
}

std::vector<std::string> AllMeshNames() {
  std::vector<std::string> names = oracle::ClosedMeshNames();
  for (const std::string& name : oracle::OpenMeshNames()) names.push_back(name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(All, SharpnessTest, testing::ValuesIn(AllMeshNames()),
                         [](const auto& mesh) { return mesh.param; });

// Two quads in a row: 0 1 2 over 3 4 5, as QuadPatch numbers them.
PolygonMesh TwoQuads() { return oracle::QuadPatch(2, 1); }

Index EdgeBetween(const HalfEdgeMesh& mesh, Index a, Index b) {
  const PolygonWalk walk(mesh);
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    const Index from = mesh.vertex()[h];
    const Index to = mesh.vertex()[walk.Next(h)];
    if ((from == a && to == b) || (from == b && to == a)) return mesh.edge()[h];
  }
  ADD_FAILURE() << "no edge";
  return kNoIndex;
}

TEST(Sharpness, OneValuePerCreaseOrOnePerEdge) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Cube());
  const PolygonMesh cube = oracle::Cube();
  // Around the first face, and one more edge of the second.
  Creases creases;
  const auto face = cube.face(0);
  creases.indices = {face[0], face[1], face[2], cube.face(1)[0], cube.face(1)[1]};
  creases.lengths = {3, 2};
  creases.sharpnesses = {2.5F, 4};
  const Sharpness by_crease = MakeOrDie(mesh, creases);
  EXPECT_EQ(by_crease.edge[EdgeBetween(mesh, face[0], face[1])], 2.5F);
  EXPECT_EQ(by_crease.edge[EdgeBetween(mesh, face[1], face[2])], 2.5F);
  EXPECT_EQ(by_crease.edge[EdgeBetween(mesh, cube.face(1)[0], cube.face(1)[1])], 4);
  creases.sharpnesses = {2.5F, 3, 4};
  const Sharpness by_edge = MakeOrDie(mesh, creases);
  EXPECT_EQ(by_edge.edge[EdgeBetween(mesh, face[0], face[1])], 2.5F);
  EXPECT_EQ(by_edge.edge[EdgeBetween(mesh, face[1], face[2])], 3);
  EXPECT_EQ(by_edge.edge[EdgeBetween(mesh, cube.face(1)[0], cube.face(1)[1])], 4);
}

TEST(Sharpness, TheLastValueOfAnEdgeCounts) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(TwoQuads());
  Creases creases;
  creases.indices = {1, 4, 4, 1};
  creases.lengths = {2, 2};
  creases.sharpnesses = {3, 2};
  EXPECT_EQ(MakeOrDie(mesh, creases).edge[EdgeBetween(mesh, 1, 4)], 2);
  EXPECT_EQ(MakeOrDie(mesh, creases).transient, 2);
  creases.sharpnesses = {3, 0};
  EXPECT_FALSE(MakeOrDie(mesh, creases).creased());
}

TEST(Sharpness, BoundariesAreSharpForeverAndCornersByTheRule) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(TwoQuads());
  Creases creases;
  creases.indices = {1, 4, 0, 1};
  creases.lengths = {2, 2};
  creases.sharpnesses = {3, 2};
  for (const BoundaryRule boundary :
       {BoundaryRule::kNone, BoundaryRule::kEdgeOnly, BoundaryRule::kEdgeAndCorner}) {
    creases.boundary = boundary;
    const Sharpness sharpness = MakeOrDie(mesh, creases);
    EXPECT_EQ(sharpness.edge[EdgeBetween(mesh, 0, 1)], kSharpForever);
    EXPECT_EQ(sharpness.edge[EdgeBetween(mesh, 1, 4)], 3);
    const float corner = boundary == BoundaryRule::kEdgeAndCorner ? kSharpForever : 0;
    EXPECT_EQ(sharpness.vertex[0], corner);
    EXPECT_EQ(sharpness.vertex[5], corner);
    EXPECT_EQ(sharpness.vertex[1], 0);
    EXPECT_EQ(sharpness.transient, 3);
    EXPECT_FALSE(sharpness.lasting);
  }
}

TEST(Sharpness, WearsOffByOneEachLevelUnlessItIsForever) {
  EXPECT_EQ(Worn(0), 0);
  EXPECT_EQ(Worn(0.3F), 0);
  EXPECT_EQ(Worn(1), 0);
  EXPECT_EQ(Worn(2.5F), 1.5F);
  EXPECT_EQ(Worn(9.5F), 8.5F);
  EXPECT_EQ(Worn(10), 10);
  EXPECT_EQ(Worn(25), 25);
  EXPECT_EQ(Worn(std::numeric_limits<float>::infinity()), std::numeric_limits<float>::infinity());
}

TEST(Sharpness, TransientSaysWhenEveryRuleIsSettled) {
  const Context context;
  HalfEdgeMesh mesh = oracle::BuildOrDie(TwoQuads());
  Creases creases;
  creases.indices = {1, 4};
  creases.lengths = {2};
  creases.sharpnesses = {1.25F};
  creases.corners = {4};
  creases.corner_sharpnesses = {2.5F};
  Sharpness sharpness = MakeOrDie(mesh, creases);
  EXPECT_EQ(sharpness.transient, 2.5F);
  for (int level = 1; level <= 3; ++level) {
    EXPECT_TRUE(sharpness.creased()) << level;
    LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoQuads(context, mesh));
    LIMN_ASSERT_OK_AND_ASSIGN(sharpness, RefineSharpness(context, mesh, split, sharpness));
    mesh = split;
  }
  EXPECT_EQ(sharpness.transient, 0);
  // Nothing is kept for what has become smooth.
  EXPECT_FALSE(sharpness.creased());
  creases.sharpnesses = {12};
  EXPECT_TRUE(MakeOrDie(oracle::BuildOrDie(TwoQuads()), creases).lasting);
}

// Faces, row by row from below, that are holes under kNone when these boundary edges of a patch of
// 4 x 4 quads are sharpened; as OpenSubdiv 3.5 answers.
TEST(Sharpness, WithoutBoundaryRuleFacesAtTheBoundaryAreHoles) {
  const PolygonMesh patch = oracle::QuadPatch(4, 4);
  const HalfEdgeMesh mesh = oracle::BuildOrDie(patch);
  const auto holes = [&](const std::vector<Index>& crease, float sharpness) {
    Creases creases;
    creases.boundary = BoundaryRule::kNone;
    if (!crease.empty()) {
      creases.indices = crease;
      creases.lengths = {static_cast<Index>(crease.size())};
      creases.sharpnesses = {sharpness};
    }
    std::string text;
    for (const std::uint8_t hole : MakeOrDie(mesh, creases).hole) text += hole != 0 ? '1' : '0';
    return text;
  };
  EXPECT_EQ(holes({}, 0), "1111100110011111");
  EXPECT_EQ(holes({0, 1, 2, 3, 4}, 10), "1001100110011111");
  EXPECT_EQ(holes({0, 1, 2, 3, 4}, 3), "1111100110011111");
  EXPECT_EQ(holes({0, 1, 2, 3}, 10), "1011100110011111");
  EXPECT_EQ(holes({0, 1, 2, 3, 4, 9, 14, 19, 24, 23, 22, 21, 20, 15, 10, 5, 0}, 10),
            "0000000000000000");
  EXPECT_TRUE(MakeOrDie(oracle::BuildOrDie(oracle::Cube()), {.boundary = BoundaryRule::kNone})
                  .hole.empty());
}

TEST(Sharpness, RulesGoByTheNumberOfSharpEdges) {
  EXPECT_EQ(RuleOf(0, 0), VertexRule::kSmooth);
  EXPECT_EQ(RuleOf(0, 1), VertexRule::kDart);
  EXPECT_EQ(RuleOf(0, 2), VertexRule::kCrease);
  EXPECT_EQ(RuleOf(0, 3), VertexRule::kCorner);
  for (const std::size_t edges : {0, 1, 2, 5}) {
    EXPECT_EQ(RuleOf(0.1F, edges), VertexRule::kCorner);
  }
}

TEST(Sharpness, EdgesBlendByTheirSharpness) {
  const Vec3 middle = {1, 0, 0};
  const Vec3 smooth = {0, 1, 0};
  EXPECT_EQ(BlendEdge(0, middle, smooth), smooth);
  EXPECT_EQ(BlendEdge(0.25F, middle, smooth), (Vec3{0.25, 0.75, 0}));
  EXPECT_EQ(BlendEdge(1, middle, smooth), middle);
  EXPECT_EQ(BlendEdge(std::numeric_limits<float>::infinity(), middle, smooth), middle);
}

// Of the coordinates, x stands for the vertex, y for the ends of sharp edges, z for the smooth
// point.
Vec3 Blend(float vertex, const std::vector<float>& edges) {
  VertexBlend blend({1, 0, 0}, vertex);
  for (const float sharpness : edges) blend.Add(sharpness, {0, 4, 0});
  return blend.Point({0, 0, 1});
}

TEST(Sharpness, VerticesBlendWhereTheirRuleChanges) {
  const Vec3 smooth = {0, 0, 1};
  const Vec3 crease = {0.75, 1, 0};
  const Vec3 corner = {1, 0, 0};
  EXPECT_EQ(Blend(0, {0, 0, 0}), smooth);
  EXPECT_EQ(Blend(0, {0, 0.5F, 0}), smooth);
  EXPECT_EQ(Blend(0, {5, 0, 10, 0}), crease);
  EXPECT_EQ(Blend(0, {2, 3, 4}), corner);
  EXPECT_EQ(Blend(10, {}), corner);
  // Crease to smooth.
  EXPECT_EQ(Blend(0, {0.25F, 0.75F}), 0.5 * crease + 0.5 * smooth);
  EXPECT_EQ(Blend(0, {1, 1}), crease);
  // Crease to dart: only the edge that vanishes counts.
  EXPECT_EQ(Blend(0, {0.25F, 5}), 0.25 * crease + 0.75 * smooth);
  // Corner to crease, to smooth, and by the vertex's own sharpness.
  EXPECT_EQ(Blend(0, {5, 5, 0.25F}), 0.25 * corner + 0.75 * crease);
  EXPECT_EQ(Blend(0.5F, {}), 0.5 * corner + 0.5 * smooth);
  EXPECT_EQ(Blend(0.5F, {0.25F, 0.25F, 0}), (1 / 3.0) * corner + (1 - 1 / 3.0) * smooth);
  EXPECT_EQ(Blend(0.5F, {5, 5}), 0.5 * corner + 0.5 * crease);
  // The rule stays although sharpness vanishes.
  EXPECT_EQ(Blend(5, {0.25F}), corner);
  EXPECT_EQ(Blend(0, {5, 5, 5, 0.25F}), corner);
}

TEST(Sharpness, RefusesWhatMakesNoSense) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(TwoQuads());
  Creases good;
  good.indices = {0, 1, 4, 3, 4};
  good.lengths = {3, 2};
  good.sharpnesses = {2, 3};
  good.corners = {1, 2};
  good.corner_sharpnesses = {1, 1};
  good.holes = {1};
  EXPECT_TRUE(MakeSharpness(Context(), mesh, good.input()).ok());
  const auto refused = [&](const oracle::ExpectedError& expected, const auto& spoil) {
    SCOPED_TRACE(expected.field);
    Creases bad = good;
    spoil(&bad);
    oracle::ExpectError(MakeSharpness(Context(), mesh, bad.input()).status(), expected);
  };
  const float nan = std::nanf("");
  refused({Reason::kIndexOutOfRange, "crease_indices[0]", 0},
          [](Creases* c) { c->indices[0] = 6; });
  refused({Reason::kIndexOutOfRange, "crease_indices[2]", 2},
          [](Creases* c) { c->indices[2] = kNoIndex; });
  refused({Reason::kInvalidOption, "crease_indices[2]", 2}, [](Creases* c) { c->indices[2] = 5; });
  refused({Reason::kInvalidOption, "crease_indices[4]", 4}, [](Creases* c) { c->indices[4] = 3; });
  refused({Reason::kInvalidOption, "crease_lengths[1]", 1}, [](Creases* c) { c->lengths[1] = 1; });
  refused({Reason::kInvalidOption, "crease_indices"}, [](Creases* c) { c->lengths[1] = 3; });
  refused({Reason::kInvalidOption, "crease_indices"}, [](Creases* c) {
    c->lengths = {kNoIndex, 2};
  });
  refused({Reason::kInvalidOption, "crease_sharpnesses"}, [](Creases* c) { c->sharpnesses = {1}; });
  refused({Reason::kInvalidOption, "crease_sharpnesses[1]", 1},
          [](Creases* c) { c->sharpnesses[1] = -1; });
  refused({Reason::kInvalidOption, "crease_sharpnesses[0]", 0},
          [&](Creases* c) { c->sharpnesses[0] = nan; });
  refused({Reason::kIndexOutOfRange, "corner_indices[1]", 1},
          [](Creases* c) { c->corners[1] = 6; });
  refused({Reason::kInvalidOption, "corner_sharpnesses"},
          [](Creases* c) { c->corner_sharpnesses.pop_back(); });
  refused({Reason::kInvalidOption, "corner_sharpnesses[0]", 0},
          [&](Creases* c) { c->corner_sharpnesses[0] = nan; });
  refused({Reason::kIndexOutOfRange, "hole_indices[0]", 0}, [](Creases* c) { c->holes[0] = 2; });
}

TEST(Sharpness, IsTheSameForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(const PolygonMesh given,
                            GenerateMesh({.kind = MeshKind::kDisk, .vertices = 20000}));
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoQuads(Context(), mesh));
  Creases creases = oracle::RandomCreases(given, 4);
  creases.boundary = BoundaryRule::kNone;
  const auto refined = [&](int threads) {
    return oracle::WithThreads(threads, [&] {
      return *RefineSharpness(Context(), mesh, split, MakeOrDie(mesh, creases));
    });
  };
  const Sharpness one = refined(1);
  for (const int threads : {2, 5}) {
    const Sharpness many = refined(threads);
    EXPECT_EQ(one.edge, many.edge);
    EXPECT_EQ(one.vertex, many.vertex);
    EXPECT_EQ(one.hole, many.hole);
  }
}

TEST(Sharpness, EndsWhenTheJobIsCancelled) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(TwoQuads());
  LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoQuads(Context(), mesh));
  const Context cancelled;
  cancelled.Cancel();
  oracle::ExpectError(MakeSharpness(cancelled, mesh, {}).status(), {Reason::kCancelled});
  oracle::ExpectError(RefineSharpness(cancelled, mesh, split, {}).status(), {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
