// SPDX-License-Identifier: MIT
#include "engine/mesh/validate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/oracle/expect.h"

namespace limn {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<Vec3> RandomPoints(std::size_t n) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  std::vector<Vec3> points(n);
  for (Vec3& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

absl::Status Validate(const std::vector<Vec3>& points) {
  BoundingBox box;
  return ValidatePositions(Context(), points, &box);
}

TEST(Validate, FindsTheBoundingBox) {
  for (const std::size_t n : {1, 100, 8192, 30000}) {
    const std::vector<Vec3> points = RandomPoints(n);
    BoundingBox box;
    ASSERT_TRUE(ValidatePositions(Context(), points, &box).ok());
    Vec3 low = points[0];
    Vec3 high = points[0];
    for (const Vec3& p : points) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
    EXPECT_EQ(box.min, low);
    EXPECT_EQ(box.max, high);
    EXPECT_NEAR(box.diagonal(), Norm(high - low), 1e-15);
  }
}

TEST(Validate, DiagonalsOfTinyAndHugeBoxesAreRight) {
  for (const double size : {1e-300, 1e-200, 1e-100, 1.0, 1e100}) {
    const BoundingBox box = {.min = {-size, 0, 0}, .max = {size, size, -2 * size}};
    EXPECT_NEAR(box.diagonal() / size, 3, 1e-15) << size;
  }
  EXPECT_EQ(BoundingBox{}.diagonal(), 0);
}

TEST(Validate, RefusesCoordinatesThatAreNotFinite) {
  for (const double bad : {std::nan(""), kInfinity, -kInfinity}) {
    for (double Vec3::*const coordinate : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      std::vector<Vec3> points = RandomPoints(30000);
      points[20001].*coordinate = bad;
      points[9000].*coordinate = bad;
      const absl::Status status = Validate(points);
      oracle::ExpectError(status, {Reason::kNonFiniteCoordinate, "mesh.vertices", 9000});
      EXPECT_NE(status.message().find("2 vertices, first vertex 9000"), std::string_view::npos)
          << status;
    }
  }
}

TEST(Validate, RefusesCoordinatesAbove1e100) {
  for (const double bad : {1.01e100, -1e101, 1e308, -1e308}) {
    for (double Vec3::*const coordinate : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      std::vector<Vec3> points = RandomPoints(100);
      points[99].*coordinate = bad;
      oracle::ExpectError(Validate(points), {Reason::kCoordinateTooLarge, "mesh.vertices", 99});
    }
  }
  std::vector<Vec3> points = RandomPoints(3);
  points[0] = {1e100, -1e100, 1e100};
  points[1] = {5e-324, -5e-324, 0};
  EXPECT_TRUE(Validate(points).ok());
}

TEST(Validate, RefusesNoPositions) {
  oracle::ExpectError(Validate({}), {Reason::kEmptyMesh, "mesh.vertices"});
}

TEST(Validate, IndicesAloneLeaveAritiesToRepair) {
  PolygonMesh mesh = oracle::Cube();
  mesh.AddFace({0, 1});
  mesh.AddFace({});
  mesh.AddFace({0, 1, 0});
  EXPECT_TRUE(ValidateIndices(Context(), mesh).ok());
  oracle::ExpectError(ValidateFaces(Context(), mesh), {Reason::kFaceTooSmall, "mesh.faces", 6});
  mesh.AddFace({0, 8});
  oracle::ExpectError(ValidateIndices(Context(), mesh),
                      {Reason::kIndexOutOfRange, "mesh.faces", 9});
}

TEST(Validate, EndsWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  BoundingBox box;
  oracle::ExpectError(ValidatePositions(cancelled, RandomPoints(10), &box), {Reason::kCancelled});
  oracle::ExpectError(ValidateFaces(cancelled, oracle::Cube()), {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
