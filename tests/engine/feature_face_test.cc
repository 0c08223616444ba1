// SPDX-License-Identifier: MIT
// Images of surface faces: against lines in space that are made to meet one by one, and every
// special case of engine/constraints/feature_face.h by itself.
#include "engine/constraints/feature_face.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/oracle/features.h"

namespace limn {
namespace {

struct Face {
  std::vector<Vec3> point;
  std::vector<double> edge;
  std::vector<double> vertex;

  std::size_t size() const { return point.size(); }
  Vec3 Centre() const {
    Vec3 sum = {0, 0, 0};
    for (const Vec3& p : point) sum += p;
    return (1.0 / static_cast<double>(size())) * sum;
  }
};

std::vector<Vec3> ImagesOf(const Face& face) {
  std::vector<Vec3> images(face.size());
  FeatureImages().Make({.point = face.point, .edge = face.edge, .vertex = face.vertex},
                       absl::MakeSpan(images));
  return images;
}

Face RegularPolygon(std::size_t m, double edge = 0.5) {
  Face face;
  for (std::size_t i = 0; i < m; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(m);
    face.point.push_back({std::cos(angle), std::sin(angle), 0.25});
  }
  face.edge.assign(m, edge);
  face.vertex.assign(m, 1);
  return face;
}

double AngleOf(const Vec3& p) { return std::atan2(p.y, p.x); }

// Whether points wind once around the z axis, each step to the left.
bool WindsOnce(const std::vector<Vec3>& points) {
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3& a = points[i];
    const Vec3& b = points[(i + 1) % points.size()];
    const double step = std::remainder(AngleOf(b) - AngleOf(a), 2 * std::numbers::pi);
    if (!(step > 0)) return false;
    sum += step;
  }
  return std::fabs(sum - 2 * std::numbers::pi) < 1e-9;
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : random_(seed) {}
  double In(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }
  // Values with many that are 0, 1 or alike.
  double Value() {
    const double draw = In(0, 1);
    if (draw < 0.15) return 0;
    if (draw < 0.3) return 1;
    return draw < 0.5 ? 0.5 : In(0, 1);
  }

 private:
  std::mt19937_64 random_;
};

// roughness 0: convex and planar, 0.3: near that, 1: anything goes.
Face RandomFace(std::size_t m, double roughness, Random* random) {
  Face face = RegularPolygon(m);
  for (Vec3& p : face.point) {
    const double radius = random->In(1, 1 + roughness);
    p = {radius * p.x + random->In(-roughness, roughness) / 2,
         radius * p.y + random->In(-roughness, roughness) / 2,
         random->In(-roughness, roughness) / 2};
    p = {p.x + 0.3 * p.z, p.y, 2 * p.z - 0.4 * p.x};
  }
  for (std::size_t i = 0; i < m; ++i) {
    face.edge[i] = random->Value();
    face.vertex[i] = random->Value();
  }
  return face;
}

TEST(FeatureFace, AgreesWithLinesThatAreMadeToMeet) {
  constexpr std::uint64_t kSeed = 91;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  Random random(kSeed);
  std::size_t reordered = 0;
  for (int run = 0; run < 6000; ++run) {
    const auto m = static_cast<std::size_t>(3 + run % 9);
    const double roughness = run % 3 == 0 ? 0 : run % 3 == 1 ? 0.3 : 1;
    const Face face = RandomFace(m, roughness, &random);
    const std::vector<Vec3> images = ImagesOf(face);
    const oracle::Points points = oracle::FromVec3(face.point);
    const std::vector<oracle::Real> edge(face.edge.begin(), face.edge.end());
    const std::vector<oracle::Real> vertex(face.vertex.begin(), face.vertex.end());
    const oracle::Points expected = oracle::FeatureImages(points, edge, vertex);
    ASSERT_LE(oracle::MaxDistance(oracle::FromVec3(images), expected), 1e-11L)
        << "run " << run << ", " << m << " corners";
    const oracle::Points raw = oracle::FeatureCrossings(points, edge);
    if (oracle::MaxDistance(raw, oracle::InSequence(points, raw)) > 1e-9L) ++reordered;
  }
  EXPECT_GT(reordered, 500U);
}

TEST(FeatureFace, EqualValuesShrinkTheFaceWhateverItsShape) {
  Random random(92);
  for (const double value : {0.0, 0.2, 0.5, 1.0}) {
    Face face = RandomFace(7, 1, &random);
    face.edge.assign(7, value);
    face.vertex.assign(7, 1);
    const std::vector<Vec3> images = ImagesOf(face);
    for (std::size_t i = 0; i < 7; ++i) {
      // With 0.5: [ZC Eq. 4].
      const Vec3 expected = (1 - value) * face.point[i] + value * face.Centre();
      EXPECT_LE(MaxAbs(images[i] - expected), 1e-15) << value;
    }
  }
}

TEST(FeatureFace, EdgeValueZeroKeepsTheVertexAndOneGivesTheCentroid) {
  Face face = RegularPolygon(5, 0.3);
  face.edge[0] = face.edge[1] = 0;
  face.edge[2] = face.edge[3] = 1;
  const std::vector<Vec3> images = ImagesOf(face);
  EXPECT_EQ(images[1], face.point[1]);
  EXPECT_LE(MaxAbs(images[3] - face.Centre()), 1e-15);
}

TEST(FeatureFace, OneValueZeroKeepsTheImageOnThatEdge) {
  Face face = RegularPolygon(6, 0.4);
  face.edge[2] = 0;
  const std::vector<Vec3> images = ImagesOf(face);
  const Vec3 along = face.point[3] - face.point[2];
  for (const std::size_t i : {std::size_t{2}, std::size_t{3}}) {
    EXPECT_LE(Norm(Cross(images[i] - face.point[2], along)), 1e-15);
    EXPECT_GT(Norm(images[i] - face.point[i]), 0.1);
  }
}

TEST(FeatureFace, VertexValueDividesTheWayToTheCrossing) {
  Random random(93);
  Face face = RandomFace(6, 0.3, &random);
  face.vertex.assign(6, 1);
  const std::vector<Vec3> crossings = ImagesOf(face);
  for (std::size_t i = 0; i < 6; ++i) face.vertex[i] = 0.2 * static_cast<double>(i);
  const std::vector<Vec3> images = ImagesOf(face);
  EXPECT_EQ(images[0], face.point[0]);
  EXPECT_LE(MaxAbs(images[5] - crossings[5]), 1e-15);
  for (std::size_t i = 0; i < 6; ++i) {
    const Vec3 expected = face.point[i] + face.vertex[i] * (crossings[i] - face.point[i]);
    EXPECT_LE(MaxAbs(images[i] - expected), 1e-15);
  }
}

// After the W_i were put in sequence the divided points may be out of it again; the values decide.
TEST(FeatureFace, DividedPointsAreNotSortedAgain) {
  // One line far outside of the others, which cross it beyond their neighbours' vertices.
  Face face = RegularPolygon(12, 0.9);
  face.edge[0] = 0.02;
  face.edge[1] = face.edge[11] = 0.95;
  const std::vector<Vec3> crossings = ImagesOf(face);
  ASSERT_TRUE(WindsOnce(crossings));
  std::size_t wrong = 0;
  for (std::size_t sharp = 0; sharp < face.size(); ++sharp) {
    face.vertex.assign(face.size(), 1);
    face.vertex[sharp] = 0;
    const std::vector<Vec3> images = ImagesOf(face);
    for (std::size_t i = 0; i < face.size(); ++i) {
      EXPECT_EQ(images[i], i == sharp ? face.point[i] : crossings[i]);
    }
    if (!WindsOnce(images)) ++wrong;
  }
  EXPECT_GT(wrong, 0U);
}

// Section 3.2.1, step 2.
TEST(FeatureFace, LinesAreParallelToEdgesAtTheirPartOfTheDistance) {
  Random random(94);
  for (int run = 0; run < 100; ++run) {
    Face face = RandomFace(5, 0, &random);
    for (double& value : face.edge) value = random.In(0.3, 0.5);
    face.vertex.assign(5, 1);
    const std::vector<Vec3> images = ImagesOf(face);
    for (std::size_t i = 0; i < 5; ++i) {
      const Vec3& a = face.point[i];
      const Vec3 along = NormalizedOrZero(face.point[(i + 1) % 5] - a);
      const auto distance = [&](const Vec3& p) { return Norm(Cross(p - a, along)); };
      const double wanted = face.edge[i] * distance(face.Centre());
      EXPECT_NEAR(distance(images[i]), wanted, 1e-14);
      EXPECT_NEAR(distance(images[(i + 1) % 5]), wanted, 1e-14);
    }
  }
}

// Section 3.2.3, Fig. 7: in the numbers of Fig. 5 the swap is that of V_5 and V_1.
TEST(FeatureFace, WrongSequenceOfThePaperIsPutRight) {
  Face face = RegularPolygon(5, 0.5);
  face.edge = {0.95, 0.5, 0.5, 0.95, 0.05};
  const std::vector<Vec3> images = ImagesOf(face);
  EXPECT_TRUE(WindsOnce(images));
  const oracle::Points crossings =
      oracle::FeatureCrossings(oracle::FromVec3(face.point), {face.edge.begin(), face.edge.end()});
  const auto distance = [&](std::size_t i, std::size_t j) {
    return oracle::Norm(oracle::FromVec3(images)[i] - crossings[j]);
  };
  EXPECT_LE(distance(4, 0), 1e-15L);
  EXPECT_LE(distance(0, 4), 1e-15L);
  for (const std::size_t i : {1, 2, 3}) EXPECT_LE(distance(i, i), 1e-15L);
}

TEST(FeatureFace, AnyNumberOfSwappedPointsIsPutRight) {
  for (const std::size_t shallow : {1U, 2U, 3U, 4U}) {
    Face face = RegularPolygon(11, 0.99);
    for (std::size_t i = 0; i < shallow; ++i) face.edge[i] = 0.01 + 0.02 * static_cast<double>(i);
    const oracle::Points points = oracle::FromVec3(face.point);
    const oracle::Points raw =
        oracle::FeatureCrossings(points, {face.edge.begin(), face.edge.end()});
    std::size_t moved = 0;
    const std::vector<Vec3> images = ImagesOf(face);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      if (oracle::Norm(oracle::FromVec3(images)[i] - raw[i]) > 1e-9L) ++moved;
    }
    EXPECT_TRUE(WindsOnce(images)) << shallow;
    // When three are turned round, the one in the middle stays.
    EXPECT_GE(moved, shallow == 4 ? 4U : 2U) << shallow;
  }
}

TEST(FeatureFace, TheSequenceDoesNotDependOnTheFirstVertex) {
  Random random(95);
  for (int run = 0; run < 200; ++run) {
    const Face face = RandomFace(8, 0.2, &random);
    const std::vector<Vec3> images = ImagesOf(face);
    for (std::size_t first = 1; first < 8; ++first) {
      Face turned = face;
      std::rotate(turned.point.begin(), turned.point.begin() + static_cast<long>(first),
                  turned.point.end());
      std::rotate(turned.edge.begin(), turned.edge.begin() + static_cast<long>(first),
                  turned.edge.end());
      std::rotate(turned.vertex.begin(), turned.vertex.begin() + static_cast<long>(first),
                  turned.vertex.end());
      const std::vector<Vec3> again = ImagesOf(turned);
      for (std::size_t i = 0; i < 8; ++i) {
        ASSERT_LE(MaxAbs(again[i] - images[(i + first) % 8]), 1e-11) << run;
      }
    }
  }
}

// An L, which does not wind around its centroid: the sequence stays, lines move towards C.
TEST(FeatureFace, ConcaveFacesThatDoNotWindKeepTheirSequence) {
  Face face;
  face.point = {{0, 0, 0}, {8, 0, 0}, {8, 1, 0}, {1, 1, 0}, {1, 8, 0}, {0, 8, 0}};
  face.edge = {0.9, 0.1, 0.8, 0.1, 0.7, 0.2};
  face.vertex.assign(6, 1);
  const std::vector<Vec3> images = ImagesOf(face);
  const Vec3 c = face.Centre();
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t before = (i + 5) % 6;
    const Vec3& v = face.point[i];
    // All edges are along an axis.
    const bool upright = face.point[(i + 1) % 6].x == v.x;
    const double along_x = upright ? face.edge[i] : face.edge[before];
    const double along_y = upright ? face.edge[before] : face.edge[i];
    EXPECT_LE(MaxAbs(images[i] - Vec3{v.x + along_x * (c.x - v.x), v.y + along_y * (c.y - v.y), 0}),
              1e-14)
        << i;
  }
}

TEST(FeatureFace, ConcaveFacesThatWindArePutInSequence) {
  Face star = RegularPolygon(10, 0.5);
  for (std::size_t i = 0; i < 10; i += 2) star.point[i] = 2.5 * star.point[i];
  for (Vec3& p : star.point) p.z = 0;
  for (std::size_t i = 0; i < 10; ++i) star.edge[i] = i % 3 == 0 ? 0.95 : 0.05;
  EXPECT_TRUE(WindsOnce(ImagesOf(star)));
}

// A vertex in the middle of a side of a square.
Face WithStraightVertex(double lift, double before, double after) {
  Face face;
  face.point = {{0, 0, 0}, {1, -lift, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  face.edge = {before, after, 0.5, 0.5, 0.5};
  face.vertex.assign(5, 1);
  return face;
}

TEST(FeatureFace, ParallelNeighboursTakeTheMeanOfTheirValues) {
  const Face face = WithStraightVertex(0, 0.2, 0.6);
  const Vec3 expected = face.point[1] + 0.4 * (face.Centre() - face.point[1]);
  EXPECT_LE(MaxAbs(ImagesOf(face)[1] - expected), 1e-15);
  // Equal values need no crossing.
  const Face equal = WithStraightVertex(0, 0.3, 0.3);
  const Vec3 same = equal.point[1] + 0.3 * (equal.Centre() - equal.point[1]);
  EXPECT_LE(MaxAbs(ImagesOf(equal)[1] - same), 1e-15);
}

TEST(FeatureFace, NearlyParallelNeighboursComeToTheSame) {
  const Vec3 straight = ImagesOf(WithStraightVertex(0, 0.2, 0.6))[1];
  for (const double lift : {1e-3, 1e-6, 1e-9, -1e-3, -1e-9}) {
    const Vec3 near = ImagesOf(WithStraightVertex(lift, 0.2, 0.6))[1];
    EXPECT_LE(MaxAbs(near - straight), 100 * std::fabs(lift)) << lift;
  }
  // On both sides of the angle from which on the rule is the paper's: sine 1/8 at lift 0.0627.
  const Vec3 below = ImagesOf(WithStraightVertex(0.0626, 0.45, 0.5))[1];
  const Vec3 above = ImagesOf(WithStraightVertex(0.0629, 0.45, 0.5))[1];
  EXPECT_LE(MaxAbs(below - above), 0.02);
}

TEST(FeatureFace, EdgesWithoutLengthHaveAnAnswer) {
  Face face = WithStraightVertex(0.5, 0.1, 0.7);
  face.point[2] = face.point[1];
  const std::vector<Vec3> images = ImagesOf(face);
  for (const Vec3& p : images) EXPECT_TRUE(IsFinite(p));
  const Vec3 to_centre = face.Centre() - face.point[1];
  // The values 0.1 and 0.7 around the first of both.
  EXPECT_LE(MaxAbs(images[1] - (face.point[1] + 0.4 * to_centre)), 1e-15);
  Face point = RegularPolygon(4);
  point.point.assign(4, Vec3{3, 2, 1});
  point.edge = {0.1, 0.9, 0, 1};
  for (const Vec3& p : ImagesOf(point)) EXPECT_EQ(p, (Vec3{3, 2, 1}));
}

// Of a face that is not planar the image is half way between the skew lines.
TEST(FeatureFace, SkewLinesMeetInTheMiddle) {
  Face face = RegularPolygon(4, 0.5);
  face.point[0].z += 0.7;
  face.edge = {0.2, 0.5, 0.5, 0.8};
  const Vec3 image = ImagesOf(face)[0];
  const Vec3 c = face.Centre();
  const auto distance = [&](std::size_t to, double value) {
    const Vec3 along = NormalizedOrZero(face.point[to] - face.point[0]);
    return Norm(Cross(image - (face.point[0] + value * (c - face.point[0])), along));
  };
  EXPECT_NEAR(distance(1, 0.2), distance(3, 0.8), 1e-15);
  EXPECT_GT(distance(1, 0.2), 0.01);
}

TEST(FeatureFace, AHugeFaceIsSortedInTime) {
  Face face = RegularPolygon(200'000);
  Random random(96);
  for (double& value : face.edge) value = random.In(0, 1);
  for (const Vec3& p : ImagesOf(face)) ASSERT_TRUE(IsFinite(p));
}

}  // namespace
}  // namespace limn
