// SPDX-License-Identifier: MIT
// Constraints follow their vertices through repair.
#include "engine/constraints/renumber.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/oracle/expect.h"

namespace limn {
namespace {

// Of five input vertices the second is left out and the fourth has become two.
const std::vector<Index> kOriginal = {0, 2, 3, 4, 3};

absl::StatusOr<Constraints> Renumbered(const Constraints& given, const std::vector<Index>& faces,
                                       const Context& context = {}) {
  return RenumberConstraints(
      context, given, {.vertex = kOriginal, .face = faces, .vertex_count = 5, .face_count = 5});
}

TEST(RenumberConstraints, EveryCopyOfAVertexGetsWhatItHad) {
  Constraints given;
  given.interpolate = {4, 3, 0};
  given.normals = {{3, {0, 0, 2}}};
  given.shape_handles = {{2, 0.5}, {3, 2}};
  LIMN_ASSERT_OK_AND_ASSIGN(const Constraints result, Renumbered(given, {}));
  EXPECT_EQ(*result.interpolate, (std::vector<Index>{3, 2, 4, 0}));
  ASSERT_EQ(result.normals.size(), 2U);
  EXPECT_EQ(result.normals[0].vertex, 2U);
  EXPECT_EQ(result.normals[1].vertex, 4U);
  EXPECT_EQ(result.normals[1].normal, (Vec3{0, 0, 2}));
  ASSERT_EQ(result.shape_handles.size(), 3U);
  EXPECT_EQ(result.shape_handles[0].vertex, 1U);
  EXPECT_EQ(result.shape_handles[2].vertex, 4U);
  EXPECT_EQ(result.shape_handles[2].value, 2);
}

TEST(RenumberConstraints, WhatIsSharpFollowsItsVerticesAndFaces) {
  Constraints given;
  given.creases = {{.vertices = {4, 0, 2}, .sharpness = {3}}};
  given.corners = {{.vertex = 3, .sharpness = 1.5F}};
  given.holes = {4, 1};
  // Face 4 has become two, face 1 is gone.
  const std::vector<Index> faces = {0, 2, 4, 3, 4};
  LIMN_ASSERT_OK_AND_ASSIGN(const Constraints result, Renumbered(given, faces));
  ASSERT_EQ(result.creases.size(), 1U);
  EXPECT_EQ(result.creases[0].vertices, (std::vector<Index>{3, 0, 1}));
  EXPECT_EQ(result.creases[0].sharpness, std::vector<float>{3});
  ASSERT_EQ(result.corners.size(), 2U);
  EXPECT_EQ(result.corners[0].vertex, 2U);
  EXPECT_EQ(result.corners[1].vertex, 4U);
  EXPECT_EQ(result.holes, (std::vector<Index>{2, 4}));
}

TEST(RenumberConstraints, FeatureValuesFollowAsDefaultsOnly) {
  Constraints given;
  given.features = FeatureValues{.default_face = FaceKind::kPlane, .default_edge = 0.125};
  LIMN_ASSERT_OK_AND_ASSIGN(const Constraints result, Renumbered(given, {}));
  ASSERT_TRUE(result.features.has_value());
  EXPECT_EQ(result.features->default_face, FaceKind::kPlane);
  EXPECT_EQ(result.features->default_edge, 0.125);
  given.features->vertices = {{.vertex = 0}};
  oracle::ExpectError(Renumbered(given, {}).status(),
                      {Reason::kInvalidOption, "constraints.features"});
}

TEST(RenumberConstraints, CreasesThroughSplitVerticesAreRefused) {
  Constraints given;
  given.creases = {{.vertices = {0, 3}, .sharpness = {1}}};
  oracle::ExpectError(Renumbered(given, {}).status(),
                      {Reason::kInvalidOption, "constraints.creases[0].vertices[1]", 1});
}

TEST(RenumberConstraints, OfCornersThatNameAVertexAgainTheLastOneCounts) {
  Constraints given;
  for (int i = 0; i < 1000; ++i) given.corners.push_back({3, static_cast<float>(i)});
  given.corners.push_back({0, 7});
  LIMN_ASSERT_OK_AND_ASSIGN(const Constraints result, Renumbered(given, {}));
  ASSERT_EQ(result.corners.size(), 3U);
  EXPECT_EQ(result.corners[0].vertex, 0U);
  EXPECT_EQ(result.corners[0].sharpness, 7);
  for (const std::size_t copy : {1, 2}) EXPECT_EQ(result.corners[copy].sharpness, 999);
}

TEST(RenumberConstraints, WhatIsNotThereIsRefusedByItsPlace) {
  Constraints given;
  given.creases = {{.vertices = {0, 4'000'000'000}, .sharpness = {1}}};
  oracle::ExpectError(Renumbered(given, {}).status(),
                      {Reason::kIndexOutOfRange, "constraints.creases[0].vertices[1]", 1});
  given.creases.clear();
  given.corners = {{0, 1}, {5, 1}};
  oracle::ExpectError(Renumbered(given, {}).status(),
                      {Reason::kIndexOutOfRange, "constraints.corners[1].vertex", 1});
  given.corners.clear();
  given.holes = {4, 5};
  oracle::ExpectError(Renumbered(given, {}).status(),
                      {Reason::kIndexOutOfRange, "constraints.holes[1]", 1});
}

TEST(RenumberConstraints, SurfacePointsFollowTheirVertices) {
  Constraints given;
  given.surface_points.resize(2);
  given.surface_points[0].vertex = 3;
  given.surface_points[0].point = {1, 2, 3};
  given.surface_points[1].vertex = 0;
  LIMN_ASSERT_OK_AND_ASSIGN(const Constraints result, Renumbered(given, {}));
  ASSERT_EQ(result.surface_points.size(), 3U);
  for (const std::size_t copy : {0, 1}) {
    EXPECT_EQ(result.surface_points[copy].point, given.surface_points[0].point);
  }
  EXPECT_NE(result.surface_points[0].vertex, result.surface_points[1].vertex);
}

TEST(RenumberConstraints, ParametersAndRegionsDoNotOutliveRepair) {
  Constraints given;
  given.surface_points.resize(1);
  given.surface_points[0].parameter = SurfaceParameter{.face = 0};
  oracle::ExpectError(Renumbered(given, {}).status(),
                      {Reason::kInvalidOption, "constraints.surface_points[0].parameter", 0});
  given.surface_points[0] = {.vertex = 0, .region = {1}};
  oracle::ExpectError(Renumbered(given, {}).status(),
                      {Reason::kInvalidOption, "constraints.surface_points[0].region", 0});
}

TEST(RenumberConstraints, StopsWhenCancelled) {
  const Context context;
  context.Cancel();
  oracle::ExpectError(Renumbered({}, {}, context).status(), {Reason::kCancelled});
}

TEST(RenumberConstraints, AllVerticesStayAllVertices) {
  LIMN_ASSERT_OK_AND_ASSIGN(const Constraints result, Renumbered({}, {}));
  EXPECT_FALSE(result.interpolate.has_value());
}

TEST(RenumberConstraints, VerticesThatRepairLeftOutAreNamed) {
  Constraints normal;
  normal.normals = {{0, {0, 0, 1}}, {1, {0, 0, 1}}};
  oracle::ExpectError(Renumbered(normal, {}).status(),
                      {Reason::kInvalidOption, "constraints.normals[1].vertex", 1});
  Constraints subset;
  subset.interpolate = {1};
  oracle::ExpectError(Renumbered(subset, {}).status(),
                      {Reason::kInvalidOption, "constraints.interpolate.vertices[0]", 0});
  Constraints handle;
  handle.shape_handles = {{1, 2}};
  oracle::ExpectError(Renumbered(handle, {}).status(),
                      {Reason::kInvalidOption, "constraints.shape_handles[0].vertex", 0});
}

}  // namespace
}  // namespace limn
