// SPDX-License-Identifier: MIT
// Rows of the limit stencil where something is sharp: held against refinement by the oracle.
#include "engine/stencil/sharp_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "tests/oracle/creased_level.h"
#include "tests/oracle/deep_limit.h"

namespace limn {
namespace {

using oracle::CreasedLevel;
using oracle::Creases;
using oracle::Rule;

class SharpRowsTest : public testing::TestWithParam<std::tuple<Rule, std::string>> {
 protected:
  static Rule rule() { return std::get<0>(GetParam()); }
  static RingKind kind() { return rule() == Rule::kLoop ? RingKind::kTriangles : RingKind::kQuads; }
};

TEST_P(SharpRowsTest, GiveTheLimitPointsOfDeepRefinement) {
  const PolygonMesh mesh = oracle::MeshFor(rule(), std::get<1>(GetParam()));
  for (const double bilinear : {0.0, 0.5}) {
    if (bilinear > 0 && rule() == Rule::kLoop) continue;
    const Creases creases = oracle::RandomCreases(mesh, 11);
    const CreasedLevel level(mesh, rule(), creases);
    LIMN_ASSERT_OK_AND_ASSIGN(const WeightedRows rows,
                              SharpRows(Context(), kind(), level.level(), bilinear));
    const oracle::CreasedMesh refined = oracle::RefineCreased(
        oracle::WithCreases(oracle::FromPolygonMesh(mesh), creases), rule(), bilinear);
    const HalfEdgeMesh& built = level.mesh;
    const PolygonWalk walk(built);
    for (std::size_t r = 0; r < rows.vertex.size(); r += 1 + rows.vertex.size() / 8) {
      const Index v = rows.vertex[r];
      Vec3 limit = mesh.positions[v];
      for (Index i = 0; i < built.valence(v); ++i) {
        const Index h = built.fan()[built.fan_begin()[v] + i];
        const Index f = built.face()[h];
        Vec3 centroid = {0, 0, 0};
        for (Index c = built.face_begin()[f]; c < built.face_begin()[f + 1]; ++c) {
          centroid += (1.0 / (built.face_begin()[f + 1] - built.face_begin()[f])) *
                      mesh.positions[built.vertex()[c]];
        }
        limit += rows.edge[rows.begin[r] + i] *
                 (mesh.positions[built.vertex()[walk.Next(h)]] - mesh.positions[v]);
        limit += rows.face[rows.begin[r] + i] * (centroid - mesh.positions[v]);
      }
      const oracle::Point d = oracle::FromVec3({&limit, 1}).front() -
                              oracle::RefineDeeply(refined, rule(), static_cast<int>(v), 60).point;
      EXPECT_LE(std::sqrt(oracle::Dot(d, d)),
                1e-13 * (1 + oracle::Diagonal(oracle::FromVec3(mesh.positions))))
          << v;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, SharpRowsTest,
                         testing::Combine(testing::Values(Rule::kCatmullClark, Rule::kLoop),
                                          testing::ValuesIn(oracle::AllMeshNames())),
                         [](const auto& test) {
                           return (std::get<0>(test.param) == Rule::kLoop ? "Loop_"
                                                                          : "CatmullClark_") +
                                  std::get<1>(test.param);
                         });

TEST(SharpRows, NoneWhereNothingIsSharp) {
  const PolygonMesh mesh = oracle::Cube();
  const CreasedLevel level(mesh, Rule::kCatmullClark, {});
  LIMN_ASSERT_OK_AND_ASSIGN(const WeightedRows rows,
                            SharpRows(Context(), RingKind::kQuads, level.level(), 0));
  EXPECT_TRUE(rows.empty());
}

}  // namespace
}  // namespace limn
