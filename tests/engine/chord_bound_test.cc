// SPDX-License-Identifier: MIT
#include "engine/limit/chord_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "engine/mesh/generate.h"
#include "tests/engine/chord_bound_testing.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/smooth_meshes.h"
#include "tests/oracle/surface.h"

namespace limn {
namespace {

PolygonMesh Generated(MeshKind kind, std::uint64_t vertices) {
  const absl::StatusOr<PolygonMesh> mesh = GenerateMesh({.kind = kind, .vertices = vertices});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *mesh;
}

class ChordBoundTest : public oracle::ClosedMeshTest {};

TEST_P(ChordBoundTest, DistanceNeverExceedsTheBound) {
  ExpectWithinBounds(oracle::SurfaceOf(mesh_));
}

// By the bounds of few levels where one of them fits, by those of all levels else.
TEST_P(ChordBoundTest, SmallestLevelThatFitsIsChosen) {
  const DooSabinSurface surface = oracle::SurfaceOf(mesh_);
  const std::vector<double> few = BoundsOf(surface, 4);
  const std::vector<double> all = BoundsOf(surface, 10);
  const double least = *std::min_element(all.begin(), all.end());
  for (double tolerance = 2 * all[0]; tolerance > least; tolerance *= 0.6) {
    const absl::StatusOr<ChordLevel> chosen =
        ChooseLevel(Context(), surface, {.tolerance = tolerance});
    ASSERT_TRUE(chosen.ok()) << chosen.status();
    EXPECT_LE(chosen->bound, tolerance);
    const bool enough = *std::min_element(few.begin(), few.end()) <= tolerance;
    const std::vector<double>& bounds = enough ? few : all;
    EXPECT_EQ(chosen->bound, bounds[chosen->level]);
    for (std::uint32_t k = 0; k < chosen->level; ++k) EXPECT_GT(bounds[k], tolerance) << k;
  }
}

TEST_P(ChordBoundTest, MoreLevelsOnlySharpenTheBounds) {
  const DooSabinSurface surface = oracle::SurfaceOf(mesh_);
  const std::vector<double> few = BoundsOf(surface, 4);
  const std::vector<double> all = BoundsOf(surface, 10);
  for (std::size_t k = 0; k < few.size(); ++k) {
    EXPECT_LE(all[k], few[k] * (1 + 1e-12)) << k;
    EXPECT_GE(all[k], 0.4 * few[k]) << k;
  }
}

TEST_P(ChordBoundTest, HasTheSameBitsForAnyNumberOfThreads) {
  const DooSabinSurface surface = oracle::SurfaceOf(mesh_);
  const auto run = [&] { return BoundsOf(surface, 6); };
  EXPECT_EQ(oracle::WithThreads(1, run), oracle::WithThreads(4, run));
}

LIMN_FOR_CLOSED_MESHES(ChordBoundTest);

// Boundary vertices of 1 to 16 faces, several loops, extraordinary points at the boundary.
constexpr char kLargeFan[] = "LargeHalfFan";
std::vector<std::string> OpenNames() {
  std::vector<std::string> names = oracle::OpenMeshNames();
  names.emplace_back(kLargeFan);
  return names;
}

class ChordBoundOpenTest : public testing::TestWithParam<std::string> {
 protected:
  const PolygonMesh mesh_ =
      GetParam() == kLargeFan ? oracle::HalfFan(16) : oracle::OpenMesh(GetParam());
};

TEST_P(ChordBoundOpenTest, DistanceNeverExceedsTheBound) {
  ExpectWithinBounds(oracle::InterpolatingSurface(mesh_));
}

TEST_P(ChordBoundOpenTest, DistanceNeverExceedsTheBoundWherePointsAreRandom) {
  ExpectWithinBounds(oracle::RandomSurface(mesh_, 4));
}

TEST_P(ChordBoundOpenTest, HasTheSameBitsForAnyNumberOfThreads) {
  const DooSabinSurface surface = oracle::InterpolatingSurface(mesh_);
  const auto run = [&] { return BoundsOf(surface, 6); };
  EXPECT_EQ(oracle::WithThreads(1, run), oracle::WithThreads(4, run));
}

INSTANTIATE_TEST_SUITE_P(Open, ChordBoundOpenTest, testing::ValuesIn(OpenNames()),
                         [](const auto& mesh) { return mesh.param; });

TEST(ChordBound, HoldsOnRoughMeshes) {
  for (const MeshKind kind : AllMeshKinds()) {
    SCOPED_TRACE(MeshKindName(kind));
    ExpectWithinBounds(oracle::InterpolatingSurface(Generated(kind, 120)));
  }
}

// Folds, as no interpolation makes them.
TEST(ChordBound, HoldsForRandomPoints) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    ExpectWithinBounds(oracle::RandomSurface(oracle::Dodecahedron(), seed));
  }
}

TEST(ChordBound, HoldsOnSmoothMeshes) {
  ExpectWithinBounds(oracle::SurfaceOf(oracle::RoundTorus(12, 8, 3, 1)));
  ExpectWithinBounds(oracle::SurfaceOf(oracle::CubeSphere(4)));
}

TEST(ChordBound, HoldsOnSmoothOpenMeshes) {
  ExpectWithinBounds(oracle::InterpolatingSurface(oracle::QuadPatch(8, 6)));
  ExpectWithinBounds(oracle::InterpolatingSurface(oracle::OpenTube(12, 5)));
}

// Not more than a small multiple of what it bounds, at every level.
TEST(ChordBound, IsNotFarAboveTheDistance) {
  for (const PolygonMesh& mesh :
       {oracle::RoundTorus(16, 8, 3, 1), oracle::CubeSphere(4), oracle::Octahedron(),
        oracle::Dodecahedron(), oracle::OpenTube(9, 4), oracle::QuadPatch(4, 3),
        oracle::QuadPatch(8, 6)}) {
    const DooSabinSurface surface = oracle::InterpolatingSurface(mesh);
    const int finest = FinestFor(surface);
    const std::vector<double> bounds = BoundsOf(surface, finest);
    const std::vector<Tessellation> levels = oracle::TessellationsOf(surface, finest);
    for (int k = 1; k + 2 < finest; ++k) {
      const auto at = static_cast<std::size_t>(k);
      EXPECT_LE(bounds[at], 9 * Measure(levels[at], levels.back(), 1).from_surface) << k;
    }
  }
}

TEST(ChordBound, FallsToAQuarterFromLevelToLevel) {
  for (const PolygonMesh& mesh :
       {oracle::CubeSphere(4), oracle::Dodecahedron(), Generated(MeshKind::kIrregularSphere, 300),
        Generated(MeshKind::kNgons, 300), Generated(MeshKind::kDisk, 300),
        oracle::OpenMesh("HalfFan6"), oracle::OpenMesh("TwoPatches")}) {
    const std::vector<double> bounds = BoundsOf(oracle::InterpolatingSurface(mesh), 10);
    for (std::size_t k = 1; k < 10; ++k) EXPECT_GT(bounds[k], 1.5 * bounds[k + 1]) << k;
    for (std::size_t k = 7; k < 10; ++k) {
      EXPECT_GT(bounds[k], 2.5 * bounds[k + 1]) << k;
      EXPECT_LT(bounds[k], 4.5 * bounds[k + 1]) << k;
    }
  }
}

TEST(ChordBound, GrowsWithTheModel) {
  const DooSabinSurface surface = oracle::SurfaceOf(oracle::Dodecahedron());
  const std::vector<double> bounds = BoundsOf(surface, 6);
  for (const double factor : {0x1p-60, 0x1p+90}) {
    DooSabinSurface scaled = surface;
    for (Vec3& p : scaled.corners) p *= factor;
    const std::vector<double> scaled_bounds = BoundsOf(scaled, 6);
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      EXPECT_EQ(scaled_bounds[k], factor * bounds[k]) << k;
    }
  }
}

TEST(ChooseLevel, RefusesWhatNoLevelMeets) {
  const DooSabinSurface surface = oracle::SurfaceOf(oracle::Cube());
  Limits limits;
  limits.max_level = 3;
  const Context context(limits);
  const double least = BoundsOf(surface, 3)[3];
  const absl::Status status = ChooseLevel(context, surface, {.tolerance = 0.999 * least}).status();
  oracle::ExpectError(status, {Reason::kLimitExceeded, "surface.chord_tolerance"});
  // The remedy names a tolerance that can be met.
  const std::string remedy = GetErrorDetail(status)->remedy;
  const double named = std::stod(remedy.substr(remedy.rfind(' ')));
  const absl::StatusOr<ChordLevel> chosen = ChooseLevel(context, surface, {.tolerance = named});
  ASSERT_TRUE(chosen.ok()) << chosen.status();
  EXPECT_EQ(chosen->level, 3U);
}

TEST(ChooseLevel, RefusesTolerancesThatMakeNoSense) {
  const DooSabinSurface surface = oracle::SurfaceOf(oracle::Cube());
  for (const double tolerance : {0.0, -1.0, std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::quiet_NaN()}) {
    oracle::ExpectError(ChooseLevel(Context(), surface, {.tolerance = tolerance}).status(),
                        {Reason::kInvalidOption, "surface.chord_tolerance"});
  }
}

TEST(ChooseLevel, StopsWhenCancelled) {
  const DooSabinSurface surface = oracle::SurfaceOf(oracle::Cube());
  const Context context;
  context.Cancel();
  oracle::ExpectError(ChooseLevel(context, surface, {.tolerance = 1}).status(),
                      {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
