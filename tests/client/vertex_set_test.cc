// SPDX-License-Identifier: MIT
// Subsets of vertices by a condition.
#include "client/vertex_set.h"

#include <gtest/gtest.h>

#include <vector>

namespace limn {
namespace {

PolygonMesh FourPoints() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, -1}, {0, 0, 2}, {5, 0, 0}, {0, 0, -0.5}};
  return mesh;
}

std::vector<Index> Vertices(const v1::VertexSet& set) {
  return {set.vertices().begin(), set.vertices().end()};
}

TEST(VerticesWhereTest, TakesThoseForWhichTheConditionHoldsInOrder) {
  const PolygonMesh mesh = FourPoints();
  EXPECT_EQ(Vertices(VerticesWhere(mesh, [](Index, const Vec3& p) { return p.z >= 0; })),
            (std::vector<Index>{1, 2}));
  EXPECT_EQ(Vertices(VerticesWhere(mesh, [](Index v, const Vec3&) { return v % 2 == 1; })),
            (std::vector<Index>{1, 3}));
}

TEST(VerticesWhereTest, AsksOnceForEachVertex) {
  std::vector<Index> asked;
  const v1::VertexSet none = VerticesWhere(FourPoints(), [&](Index v, const Vec3&) {
    asked.push_back(v);
    return false;
  });
  EXPECT_EQ(none.vertices_size(), 0);
  EXPECT_EQ(asked, (std::vector<Index>{0, 1, 2, 3}));
}

TEST(VerticesWhereTest, AnEmptyMeshHasNone) {
  EXPECT_EQ(VerticesWhere(PolygonMesh{}, [](Index, const Vec3&) { return true; }).vertices_size(),
            0);
}

}  // namespace
}  // namespace limn
