// SPDX-License-Identifier: MIT
#include "engine/constraints/perturb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "engine/mesh/generate.h"
#include "engine/refine/doo_sabin_refine.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::Points;
using oracle::Real;

// The images of one vertex before and after.
struct Images {
  Points before;
  Points after;
  oracle::Point target;

  oracle::Point epsilon(std::size_t i) const { return after[i] - before[i]; }
};

// Perturbs these corners of a mesh; the images of each vertex are in the order of its fan.
std::vector<Images> PerturbCorners(const PolygonMesh& given, std::vector<Vec3> corners) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  const Points before = oracle::FromVec3(corners);
  EXPECT_TRUE(
      PerturbToInterpolate(Context(), {mesh, given.positions}, absl::MakeSpan(corners)).ok());
  const Points after = oracle::FromVec3(corners);
  const Points targets = oracle::FromVec3(given.positions);
  std::vector<Images> faces(mesh.vertex_count());
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    faces[v].target = targets[v];
    for (const Index h : mesh.fan().subspan(mesh.fan_begin()[v], mesh.valence(v))) {
      faces[v].before.push_back(before[h]);
      faces[v].after.push_back(after[h]);
    }
  }
  return faces;
}

// One vertex of valence m with these images and target; the rest of the mesh does not matter.
Images PerturbOne(const std::vector<Vec3>& images, const Vec3& target) {
  PolygonMesh given = images.size() == 2 ? oracle::Pillow(3)
                                         : oracle::DoublePyramid(static_cast<int>(images.size()));
  given.positions[0] = target;
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  std::vector<Vec3> corners(mesh.half_edge_count(), Vec3{0, 0, 0});
  for (std::size_t i = 0; i < images.size(); ++i) corners[mesh.fan()[i]] = images[i];
  return PerturbCorners(given, corners)[0];
}

Vec3 Near(std::mt19937_64* random, const Vec3& center, double size) {
  std::uniform_real_distribution<double> coordinate(-size, size);
  return center + Vec3{coordinate(*random), coordinate(*random), coordinate(*random)};
}

// The images as the first refinement of the given mesh leaves them, and stirred.
std::vector<Images> StirredFaces(const PolygonMesh& given) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  std::vector<Vec3> corners(mesh.half_edge_count());
  EXPECT_TRUE(FirstRefinement(Context(), mesh, given.positions, absl::MakeSpan(corners)).ok());
  std::mt19937_64 random(5);
  for (Vec3& p : corners) p = Near(&random, p, 0.1);
  return PerturbCorners(given, corners);
}

class PerturbTest : public oracle::ClosedMeshTest {};

TEST_P(PerturbTest, PutsTheCentroidOnThePoint) {
  for (const Images& face : StirredFaces(mesh_)) {
    EXPECT_LE(oracle::Norm(oracle::Centroid(face.after) - face.target),
              1e-15 * oracle::Diagonal(given_.points));
  }
}

TEST_P(PerturbTest, PutsTheImagesIntoThePlaneOfTheirAverageNormal) {
  for (const Images& face : StirredFaces(mesh_)) {
    if (face.before.size() < 3) continue;
    const oracle::Point normal = oracle::Equation10(face.before);
    for (const oracle::Point& p : face.after) {
      EXPECT_LE(std::abs(oracle::Dot(p - face.target, normal)),
                1e-13 * oracle::Diagonal(given_.points));
    }
  }
}

TEST_P(PerturbTest, IsEquationSeventeen) {
  for (const Images& face : StirredFaces(mesh_)) {
    EXPECT_LE(oracle::MaxDistance(face.after, oracle::Equation17(face.before, face.target)),
              1e-13 * oracle::Diagonal(given_.points));
  }
}

// Eq. 9 under Eqs. 8 and 11: the perturbation is orthogonal to every change that keeps them, that
// is to changes inside the plane that add up to zero.
TEST_P(PerturbTest, IsTheSmallestThatMeetsTheConstraints) {
  std::mt19937_64 random(6);
  for (const Images& face : StirredFaces(mesh_)) {
    if (face.before.size() < 3) continue;
    const oracle::Point normal = oracle::Equation10(face.before);
    Points change;
    for (std::size_t i = 0; i < face.before.size(); ++i) {
      change.push_back(oracle::FromVec3({Near(&random, {0, 0, 0}, 1)})[0]);
    }
    const oracle::Point mean = oracle::Centroid(change);
    Real product = 0;
    for (std::size_t i = 0; i < change.size(); ++i) {
      oracle::Point d = change[i] - mean;
      d = d - oracle::Dot(d, normal) * normal;
      product += oracle::Dot(face.epsilon(i), d);
    }
    EXPECT_NEAR(static_cast<double>(product), 0,
                1e-13 * static_cast<double>(oracle::Diagonal(given_.points)) * change.size());
  }
}

LIMN_FOR_CLOSED_MESHES(PerturbTest);

// What has no plane is only translated: the images keep their offsets from the centroid.
void ExpectOnlyTranslated(const std::vector<Vec3>& images, const Vec3& target, double tolerance) {
  const Images face = PerturbOne(images, target);
  const oracle::Point shift = face.target - oracle::Centroid(face.before);
  for (std::size_t i = 0; i < images.size(); ++i) {
    EXPECT_LE(oracle::Norm(face.epsilon(i) - shift), tolerance) << "image " << i;
  }
}

TEST(Perturb, OnlyTranslatesTheTwoImagesOfAVertexOfValenceTwo) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 100; ++i) {
    const Vec3 center = Near(&random, {0, 0, 0}, 3);
    ExpectOnlyTranslated({Near(&random, center, 1), Near(&random, center, 1)},
                         Near(&random, center, 1), 1e-14);
  }
}

TEST(Perturb, OnlyTranslatesImagesOnOneLine) {
  std::mt19937_64 random(8);
  for (int i = 0; i < 100; ++i) {
    const Vec3 a = Near(&random, {0, 0, 0}, 3);
    const Vec3 along = Near(&random, {0, 0, 0}, 1);
    std::vector<Vec3> images;
    for (const double t : {0.1, 0.35, 0.7, 1.1, -0.4}) images.push_back(a + t * along);
    ExpectOnlyTranslated(images, Near(&random, a, 1), 1e-14);
  }
}

TEST(Perturb, OnlyTranslatesCoincidentImages) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 100; ++i) {
    const Vec3 a = Near(&random, {0, 0, 0}, 3);
    ExpectOnlyTranslated(std::vector<Vec3>(5, a), Near(&random, a, 1), 2e-15);
  }
}

TEST(Perturb, OnlyTranslatesImagesThatEncloseNoArea) {
  // Figures of eight whose loops cancel.
  std::mt19937_64 random(10);
  for (int i = 0; i < 100; ++i) {
    const Vec3 c = Near(&random, {0, 0, 0}, 3);
    const Vec3 u = Near(&random, {0, 0, 0}, 1);
    const Vec3 v = Near(&random, {0, 0, 0}, 1);
    ExpectOnlyTranslated({c + u + v, c - u - v, c - u + v, c + u - v}, Near(&random, c, 1), 1e-14);
  }
}

TEST(Perturb, KeepsPlanarFacesThatAreInPlace) {
  const std::vector<Vec3> images = {{1, 0, 2}, {0, 1, 2}, {-1, 0, 2}, {0, -1, 2}};
  const Images face = PerturbOne(images, {0, 0, 2});
  EXPECT_LE(oracle::MaxDistance(face.before, face.after), 1e-15);
}

// Sizes at both ends of what coordinates may be: relative accuracy is that of size 1.
TEST(Perturb, IsEquationSeventeenForTinyAndHugeCoordinates) {
  std::mt19937_64 random(11);
  std::vector<Vec3> images;
  for (int i = 0; i < 5; ++i) images.push_back(Near(&random, {0.5, 1, -0.25}, 1));
  const Vec3 target = {1, -1, 2};
  for (const double size : {1e-300, 1e-200, 1e-100, 1e-50, 1.0, 1e50, 1e90}) {
    SCOPED_TRACE(size);
    std::vector<Vec3> scaled;
    for (const Vec3& p : images) scaled.push_back(size * p);
    const Images face = PerturbOne(scaled, size * target);
    EXPECT_LE(oracle::MaxDistance(face.after, oracle::Equation17(face.before, face.target)),
              1e-14 * size);
  }
}

TEST(Perturb, AverageNormalIsEquationTenAndZeroWithoutArea) {
  std::mt19937_64 random(12);
  for (const std::size_t m : {3, 4, 5, 12}) {
    std::vector<Vec3> p;
    for (std::size_t i = 0; i < m; ++i) p.push_back(Near(&random, {1, 2, 3}, 1));
    const Points points = oracle::FromVec3(p);
    const oracle::Point c = oracle::Centroid(points);
    const Vec3 centroid = {static_cast<double>(c.x), static_cast<double>(c.y),
                           static_cast<double>(c.z)};
    const Vec3 normal = AverageNormal(m, centroid, [&](std::size_t i) { return p[i]; });
    EXPECT_LE(oracle::Norm(oracle::FromVec3({normal})[0] - oracle::Equation10(points)), 1e-13);
    const Vec3 none = AverageNormal(m, p[0], [&](std::size_t) { return p[0]; });
    EXPECT_EQ(none, (Vec3{0, 0, 0}));
  }
}

TEST(Perturb, HasTheSameBitsForAnyNumberOfThreads) {
  LIMN_ASSERT_OK_AND_ASSIGN(
      const PolygonMesh given,
      GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 20000, .seed = 4}));
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  const auto perturb = [&](int threads) {
    return oracle::WithThreads(threads, [&] {
      std::vector<Vec3> corners(mesh.half_edge_count());
      EXPECT_TRUE(FirstRefinement(Context(), mesh, given.positions, absl::MakeSpan(corners)).ok());
      EXPECT_TRUE(
          PerturbToInterpolate(Context(), {mesh, given.positions}, absl::MakeSpan(corners)).ok());
      return corners;
    });
  };
  const std::vector<Vec3> one = perturb(1);
  for (const int threads : {2, 5}) EXPECT_EQ(one, perturb(threads));
}

TEST(Perturb, EndsWhenTheJobIsCancelled) {
  const Context cancelled;
  cancelled.Cancel();
  const PolygonMesh cube = oracle::Cube();
  std::vector<Vec3> corners(24, Vec3{0, 0, 0});
  oracle::ExpectError(PerturbToInterpolate(cancelled, {oracle::BuildOrDie(cube), cube.positions},
                                           absl::MakeSpan(corners)),
                      {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
