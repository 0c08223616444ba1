// SPDX-License-Identifier: MIT
// Distances between a surface and its targets.
#include "engine/constraints/certificate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace limn {
namespace {

Buffer<Vec3> RandomPoints(std::size_t n, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  Buffer<Vec3> points(n);
  for (Vec3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

TEST(CertificateTest, TellsLargestAndMeanDistanceAndWhere) {
  CertificateBuilder builder(Buffer<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 2}});
  EXPECT_FALSE(builder.complete());
  builder.AddRun(0, Buffer<Vec3>{{0, 0, 0}, {1, 3, 4}, {0, 2, 1}, {0, 0, 2}, {9, 9, 9}});
  EXPECT_TRUE(builder.complete());
  const Certificate certificate = builder.Finish();
  EXPECT_EQ(certificate.points_checked, 4U);
  EXPECT_EQ(certificate.max_error, 5);
  EXPECT_EQ(certificate.max_error_vertex, 1U);
  EXPECT_EQ(certificate.mean_error, 1.5);
  EXPECT_EQ(certificate.bounding_box_diagonal, 3);
}

TEST(CertificateTest, HasTheSameBitsForAnyOrderOfTheRuns) {
  const Buffer<Vec3> targets = RandomPoints(1000, 1);
  const Buffer<Vec3> surface = RandomPoints(2000, 2);
  CertificateBuilder whole(targets);
  whole.AddRun(0, surface);
  CertificateBuilder pieces(targets);
  for (std::size_t begin = 1995; begin + 5 > 0 && begin < surface.size(); begin -= 5) {
    pieces.AddRun(begin, absl::MakeConstSpan(surface).subspan(begin, 5));
  }
  EXPECT_EQ(whole.Finish().max_error, pieces.Finish().max_error);
  EXPECT_EQ(whole.Finish().mean_error, pieces.Finish().mean_error);
  EXPECT_EQ(whole.Finish().max_error_vertex, pieces.Finish().max_error_vertex);
}

TEST(CertificateTest, CountsAVertexOnceAndItsLargerDistance) {
  CertificateBuilder builder(Buffer<Vec3>{{0, 0, 0}, {1, 1, 1}});
  builder.Add(0, {3, 0, 0});
  builder.Add(0, {1, 0, 0});
  const Certificate certificate = builder.Finish();
  EXPECT_EQ(certificate.points_checked, 1U);
  EXPECT_EQ(certificate.max_error, 3);
}

TEST(CertificateTest, APositionThatIsNotFiniteIsNeverHidden) {
  CertificateBuilder builder(Buffer<Vec3>{{0, 0, 0}, {1, 1, 1}});
  builder.AddRun(0, Buffer<Vec3>{{0, std::nan(""), 0}, {1, 1, 1}});
  EXPECT_EQ(builder.Finish().max_error, std::numeric_limits<double>::infinity());
  EXPECT_EQ(builder.Finish().max_error_vertex, 0U);
}

TEST(CertificateTest, TinyAndHugeDistancesNeitherVanishNorOverflow) {
  CertificateBuilder tiny(Buffer<Vec3>{{0, 0, 0}});
  tiny.Add(0, {3e-200, 4e-200, 0});
  EXPECT_DOUBLE_EQ(tiny.Finish().max_error, 5e-200);
  CertificateBuilder huge(Buffer<Vec3>{{0, 0, 0}});
  huge.Add(0, {3e200, 4e200, 0});
  EXPECT_DOUBLE_EQ(huge.Finish().max_error, 5e200);
}

TEST(CertificateTest, OnlyInterpolatedVerticesCount) {
  CertificateBuilder builder(Buffer<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 2}},
                             {.interpolate = std::vector<Index>{3, 1}});
  EXPECT_TRUE(builder.counts(1));
  EXPECT_TRUE(builder.counts(3));
  for (const Index v : {0U, 2U, 4U, kNoIndex}) EXPECT_FALSE(builder.counts(v)) << v;
  builder.AddRun(0, Buffer<Vec3>{{9, 9, 9}, {1, 0, 1}, {9, 9, 9}});
  EXPECT_FALSE(builder.complete());
  builder.Add(3, {0, 3, 2});
  EXPECT_TRUE(builder.complete());
  const Certificate certificate = builder.Finish();
  EXPECT_EQ(certificate.points_checked, 2U);
  EXPECT_EQ(certificate.max_error, 3);
  EXPECT_EQ(certificate.max_error_vertex, 3U);
  EXPECT_EQ(certificate.mean_error, 2);
  // Of all that was given.
  EXPECT_EQ(certificate.bounding_box_diagonal, 3);
}

TEST(CertificateTest, AnEmptySubsetChecksNothing) {
  CertificateBuilder builder(Buffer<Vec3>{{0, 0, 0}, {1, 0, 0}},
                             {.interpolate = std::vector<Index>{}});
  EXPECT_TRUE(builder.complete());
  builder.AddRun(0, Buffer<Vec3>{{9, 9, 9}, {9, 9, 9}});
  const Certificate certificate = builder.Finish();
  EXPECT_EQ(certificate.points_checked, 0U);
  EXPECT_EQ(certificate.max_error, 0);
  EXPECT_EQ(certificate.mean_error, 0);
}

// At vertices 1, 4 and 7 of 8, in any order.
CertificateBuilder WithNormals() {
  return CertificateBuilder(RandomPoints(8, 3),
                            {.normals = {{7, {0, 0, 1e-300}}, {1, {1e300, 0, 0}}, {4, {0, 2, 2}}}});
}

TEST(CertificateTest, TellsTheLargestAngleAndWhere) {
  CertificateBuilder builder = WithNormals();
  Buffer<Vec3> normals(10, {0, 0, 1});
  normals[1] = {std::cos(0.01), std::sin(0.01), 0};
  normals[4] = {0, std::cos(0.5), std::sin(0.5)};
  builder.AddRun(0, RandomPoints(8, 3));
  EXPECT_FALSE(builder.complete());
  builder.AddNormalRun(0, normals);
  EXPECT_TRUE(builder.complete());
  const Certificate certificate = builder.Finish();
  EXPECT_EQ(certificate.normals_checked, 3U);
  EXPECT_NEAR(certificate.max_normal_deviation, std::atan(1.0) - 0.5, 1e-15);
  EXPECT_EQ(certificate.max_normal_deviation_vertex, 4U);
  EXPECT_EQ(certificate.points_checked, 8U);
}

TEST(CertificateTest, NormalsInPiecesAndOneByOneGiveTheSame) {
  const Buffer<Vec3> normals = RandomPoints(8, 4);
  CertificateBuilder whole = WithNormals();
  whole.AddNormalRun(0, normals);
  CertificateBuilder pieces = WithNormals();
  pieces.AddNormalRun(5, absl::MakeConstSpan(normals).subspan(5));
  pieces.AddNormalRun(2, absl::MakeConstSpan(normals).subspan(2, 3));
  pieces.AddNormalRun(0, absl::MakeConstSpan(normals).subspan(0, 2));
  CertificateBuilder single = WithNormals();
  for (std::size_t v = normals.size(); v-- > 0;) single.AddNormal(v, normals[v]);
  for (CertificateBuilder* other : {&pieces, &single}) {
    EXPECT_EQ(other->Finish().normals_checked, 3U);
    EXPECT_EQ(other->Finish().max_normal_deviation, whole.Finish().max_normal_deviation);
    EXPECT_EQ(other->Finish().max_normal_deviation_vertex,
              whole.Finish().max_normal_deviation_vertex);
  }
}

TEST(CertificateTest, ANormalToldAgainCountsOnceAndItsLargerAngle) {
  CertificateBuilder builder = WithNormals();
  builder.AddNormal(7, {0, 1, 1});
  builder.AddNormal(7, {0, 0, 1});
  EXPECT_EQ(builder.Finish().normals_checked, 1U);
  EXPECT_NEAR(builder.Finish().max_normal_deviation, std::atan(1.0), 1e-15);
}

TEST(CertificateTest, AnUndefinedNormalIsARightAngle) {
  for (const Vec3& undefined : {Vec3{0, 0, 0}, Vec3{std::nan(""), 0, 1}, Vec3{1, std::nan(""), 0},
                                Vec3{0, 0, std::numeric_limits<double>::infinity()}}) {
    CertificateBuilder builder = WithNormals();
    builder.AddNormal(7, undefined);
    EXPECT_EQ(builder.Finish().max_normal_deviation, std::acos(0.0));
    EXPECT_EQ(builder.Finish().max_normal_deviation_vertex, 7U);
  }
}

TEST(AngleBetweenLinesTest, SeesTheSmallestAnglesAndTakesOppositesAsTheSame) {
  const Vec3 n = {0.48, 0.6, 0.64};
  const Vec3 across = {0.8, 0, -0.6};
  for (const double angle : {1e-16, 1e-12, 1e-10, 1e-6, 0.1, 1.0, 1.57}) {
    const Vec3 turned = std::cos(angle) * n + std::sin(angle) * across;
    for (const double sign : {1.0, -1.0}) {
      EXPECT_NEAR(AngleBetweenLines(n, sign * turned), angle, 2e-16 + 1e-15 * angle);
      EXPECT_NEAR(AngleBetweenLines(1e200 * n, (sign * 1e-200) * turned), angle,
                  4e-16 + 1e-15 * angle);
    }
  }
  EXPECT_EQ(AngleBetweenLines({0, 0, 2}, {0, 0, -3}), 0);
  EXPECT_EQ(AngleBetweenLines({0, 0, 2}, {0, 5, 0}), std::acos(0.0));
}

TEST(CertificateTest, NothingCheckedIsNoError) {
  const Certificate certificate = CertificateBuilder(Buffer<Vec3>{}).Finish();
  EXPECT_EQ(certificate.points_checked, 0U);
  EXPECT_EQ(certificate.max_error, 0);
  EXPECT_EQ(certificate.mean_error, 0);
  EXPECT_EQ(certificate.normals_checked, 0U);
  EXPECT_EQ(certificate.max_normal_deviation, 0);
}

}  // namespace
}  // namespace limn
