// SPDX-License-Identifier: MIT
// Distances between a surface and its targets.
#include "engine/limit/certificate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

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

TEST(CertificateTest, NothingCheckedIsNoError) {
  const Certificate certificate = CertificateBuilder(Buffer<Vec3>{}).Finish();
  EXPECT_EQ(certificate.points_checked, 0U);
  EXPECT_EQ(certificate.max_error, 0);
  EXPECT_EQ(certificate.mean_error, 0);
}

}  // namespace
}  // namespace limn
