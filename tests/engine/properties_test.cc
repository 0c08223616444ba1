// SPDX-License-Identifier: MIT
// Properties of Doo-Sabin interpolation that hold for any mesh, over random ones, open and closed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/constraints/perturb.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "engine/mesh/quad_split.h"
#include "engine/refine/doo_sabin_refine.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/open_meshes.h"

namespace limn {
namespace {

struct RandomMesh {
  MeshKind kind;
  std::uint64_t seed;
};

class PropertiesTest : public testing::TestWithParam<RandomMesh> {
 protected:
  PropertiesTest() {
    auto mesh = GenerateMesh({.kind = GetParam().kind, .vertices = 400, .seed = GetParam().seed});
    EXPECT_TRUE(mesh.ok()) << mesh.status();
    if (mesh.ok()) mesh_ = *std::move(mesh);
    size_ = static_cast<double>(oracle::Diagonal(oracle::FromVec3(mesh_.positions)));
  }

  // With a subset, handles and, where wanted, normals that a linear map keeps or moves.
  InterpolateOptions Wishes(const std::function<Vec3(const Vec3&)>& turn) const {
    InterpolateOptions options = {.level = 2};
    options.constraints.interpolate.emplace();
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      if (v % 4 == 1) continue;
      options.constraints.interpolate->push_back(v);
      if (v % 8 == 0) options.constraints.normals.push_back({v, turn({0.5, 0.3, 1})});
      if (v % 16 == 0) options.constraints.shape_handles.push_back({v, 0.6});
    }
    return options;
  }

  Tessellation Surface(const PolygonMesh& mesh, const InterpolateOptions& options) const {
    auto result = Interpolate(Context(), mesh, options);
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() ? std::move(result->surface) : Tessellation{};
  }

  PolygonMesh mesh_;
  double size_ = 0;
};

// Constraints turn with the mesh; a mirror turns faces, so it is among the affine maps below.
TEST_P(PropertiesTest, SimilaritiesMoveTheConstrainedSurface) {
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  const auto turn = [&](const Vec3& p) {
    return Vec3{c * p.x - s * p.y, 0.8 * (s * p.x + c * p.y) - 0.6 * p.z,
                0.6 * (s * p.x + c * p.y) + 0.8 * p.z};
  };
  PolygonMesh moved = mesh_;
  for (Vec3& p : moved.positions) p = 2.5 * turn(p) + Vec3{1, -2, 0.5};
  const Tessellation before = Surface(mesh_, Wishes([](const Vec3& n) { return n; }));
  const Tessellation after = Surface(moved, Wishes(turn));
  ASSERT_EQ(before.vertex_count(), after.vertex_count());
  for (std::size_t v = 0; v < before.vertex_count(); ++v) {
    ASSERT_LE(MaxAbs(2.5 * turn(before.positions[v]) + Vec3{1, -2, 0.5} - after.positions[v]),
              1e-10 * size_)
        << v;
  }
}

// Without the projection of Eq. 17, that is for vertices that are not interpolated, everything is
// linear: any affine map will do, mirrors among them.
TEST_P(PropertiesTest, AffineMapsMoveTheUnprojectedSurface) {
  const auto map = [](const Vec3& p) {
    return Vec3{-2 * p.x + 0.3 * p.y + 1, 0.5 * p.y - p.z, 0.1 * p.x + 3 * p.z - 4};
  };
  PolygonMesh moved = mesh_;
  for (Vec3& p : moved.positions) p = map(p);
  const InterpolateOptions options = {.constraints = {.interpolate = std::vector<Index>{}},
                                      .level = 3};
  const Tessellation before = Surface(mesh_, options);
  const Tessellation after = Surface(moved, options);
  for (std::size_t v = 0; v < before.vertex_count(); ++v) {
    ASSERT_LE(MaxAbs(map(before.positions[v]) - after.positions[v]), 1e-12 * size_) << v;
  }
}

// The control mesh is a linear function of the points, and the equations' rows add up to 1.
TEST_P(PropertiesTest, AffineMapsMoveTheInterpolatingControlMesh) {
  const auto map = [](const Vec3& p) {
    return Vec3{-2 * p.x + 0.3 * p.y + 1, 0.5 * p.y - p.z, 0.1 * p.x + 3 * p.z - 4};
  };
  PolygonMesh moved = mesh_;
  for (Vec3& p : moved.positions) p = map(p);
  const auto solve = [](const PolygonMesh& mesh) {
    auto result = Interpolate(Context(), mesh, {.solve = {.tolerance = 1e-14}, .surface = false});
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() ? std::move(result->control_positions) : Buffer<Vec3>{};
  };
  const Buffer<Vec3> before = solve(mesh_);
  const Buffer<Vec3> after = solve(moved);
  ASSERT_EQ(before.size(), mesh_.vertex_count());
  ASSERT_EQ(after.size(), mesh_.vertex_count());
  for (std::size_t v = 0; v < before.size(); ++v) {
    ASSERT_LE(MaxAbs(map(before[v]) - after[v]), 1e-12 * size_) << v;
  }
}

// Faces of M^1 that are planar stay in their planes, and every centroid stays where it is.
TEST_P(PropertiesTest, RefinementKeepsCentroidsAndPlanes) {
  auto result = Interpolate(Context(), mesh_, {.level = 0, .surface = false, .keep_patches = true});
  ASSERT_TRUE(result.ok()) << result.status();
  const DooSabinSurface& coarse = std::get<DooSabinSurface>(*result->patches);
  Buffer<Vec3> refined(4 * coarse.mesh.half_edge_count());
  ASSERT_TRUE(
      RefineDooSabin(Context(),
                     {.mesh = coarse.mesh, .fans = {}, .k = 1, .boundary = &coarse.boundary},
                     coarse.corners, absl::MakeSpan(refined))
          .ok());
  for (Index v = 0; v < coarse.mesh.vertex_count(); ++v) {
    const auto fan = coarse.mesh.fan().subspan(coarse.mesh.fan_begin()[v], coarse.mesh.valence(v));
    // The images of a boundary vertex are half of its face.
    if (coarse.mesh.twin()[fan[0]] == kNoIndex) continue;
    const std::size_t m = fan.size();
    const auto old_point = [&](std::size_t i) { return coarse.corners[fan[i]]; };
    Vec3 before = {0, 0, 0};
    Vec3 after = {0, 0, 0};
    for (std::size_t i = 0; i < m; ++i) {
      before += (1.0 / static_cast<double>(m)) * old_point(i);
      after += (1.0 / static_cast<double>(m)) * refined[4 * std::size_t{fan[i]}];
    }
    ASSERT_LE(MaxAbs(before - after), 1e-14 * size_) << v;
    const Vec3 normal = AverageNormal(m, before, old_point);
    for (std::size_t i = 0; i < m; ++i) {
      ASSERT_LE(std::fabs(Dot(refined[4 * std::size_t{fan[i]}] - after, normal)), 1e-13 * size_)
          << v;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Random, PropertiesTest, testing::ValuesIn([] {
                           std::vector<RandomMesh> meshes;
                           for (const MeshKind kind : AllMeshKinds()) {
                             for (const std::uint64_t seed : {11, 12, 13})
                               meshes.push_back({kind, seed});
                           }
                           return meshes;
                         }()),
                         [](const auto& mesh) {
                           return std::string(MeshKindName(mesh.param.kind)) + "_seed_" +
                                  std::to_string(mesh.param.seed);
                         });

// Whether the set of points is mapped onto itself.
void ExpectSymmetric(const Tessellation& surface, const std::function<Vec3(const Vec3&)>& map) {
  double largest = 0;
  for (const Vec3& p : surface.positions) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& q : surface.positions) nearest = std::min(nearest, MaxAbs(map(p) - q));
    largest = std::max(largest, nearest);
  }
  EXPECT_LE(largest, 1e-12);
}

TEST(Properties, SymmetricMeshesHaveSymmetricSurfaces) {
  const auto surface = [](const PolygonMesh& mesh) {
    auto result = Interpolate(Context(), mesh, {.level = 3});
    EXPECT_TRUE(result.ok()) << result.status();
    return std::move(result->surface);
  };
  // The cube's own symmetries about its centre.
  const Tessellation cube = surface(oracle::Cube());
  Vec3 centre = {0, 0, 0};
  for (const Vec3& p : oracle::Cube().positions) centre += 0.125 * p;
  ExpectSymmetric(cube, [&](const Vec3& p) {
    const Vec3 d = p - centre;
    return centre + Vec3{d.y, d.z, d.x};
  });
  ExpectSymmetric(cube, [&](const Vec3& p) {
    const Vec3 d = p - centre;
    return centre + Vec3{-d.x, d.y, d.z};
  });
  // A flat regular octagon, and an open tube.
  PolygonMesh octagon = oracle::SinglePolygon(8);
  for (Vec3& p : octagon.positions) p.z = 0;
  const auto turned = [](double angle) {
    return [angle](const Vec3& p) {
      return Vec3{std::cos(angle) * p.x - std::sin(angle) * p.y,
                  std::sin(angle) * p.x + std::cos(angle) * p.y, p.z};
    };
  };
  ExpectSymmetric(surface(octagon), turned(std::acos(-1.0) / 4));
  ExpectSymmetric(surface(octagon), [](const Vec3& p) { return Vec3{p.x, -p.y, p.z}; });
  ExpectSymmetric(surface(oracle::OpenTube(6, 2)), turned(2 * std::acos(-1.0) / 3));
}

}  // namespace
}  // namespace limn
