// SPDX-License-Identifier: MIT
#include "engine/limit/chord_bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "engine/mesh/generate.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/smooth_meshes.h"
#include "tests/oracle/surface.h"
#include "tests/oracle/tessellations.h"
#include "tests/oracle/triangle_tree.h"

namespace limn {
namespace {

std::vector<double> BoundsOf(const DooSabinSurface& surface, int finest) {
  const absl::StatusOr<std::vector<double>> bounds = ChordBounds(Context(), surface, finest);
  EXPECT_TRUE(bounds.ok()) << bounds.status();
  return bounds.ok() ? *bounds : std::vector<double>();
}

PolygonMesh Generated(MeshKind kind, std::uint64_t vertices) {
  const absl::StatusOr<PolygonMesh> mesh = GenerateMesh({.kind = kind, .vertices = vertices});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *mesh;
}

// The deepest level that is looked at: T^finest stands for the surface. Its vertices lie on it.
int FinestFor(const DooSabinSurface& surface) {
  int finest = 4;
  std::size_t quads = 64 * surface.corners.size();
  while (finest < 7 && 4 * quads < 150000) {
    quads *= 4;
    ++finest;
  }
  return finest;
}

// The largest distance of the surface's points to T^k, and of T^k's points to T^finest.
struct Measured {
  double from_surface = 0;
  double from_tessellation = 0;
};
Measured Measure(const Tessellation& coarse, const Tessellation& fine, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const std::vector<oracle::Triangle> coarse_triangles = oracle::SplitAtRandom(coarse, &random);
  const oracle::TriangleTree coarse_tree(coarse_triangles);
  const oracle::TriangleTree fine_tree(oracle::SplitAtRandom(fine, &random));
  Measured measured;
  for (const Vec3& p : fine.positions) {
    measured.from_surface = std::max(measured.from_surface, coarse_tree.Distance(p));
  }
  constexpr int kSteps = 3;
  for (const auto& [a, b, c] : coarse_triangles) {
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const Vec3 p = a + (1.0 / kSteps) * (i * (b - a) + j * (c - a));
        measured.from_tessellation = std::max(measured.from_tessellation, fine_tree.Distance(p));
      }
    }
  }
  return measured;
}

void ExpectWithinBounds(const DooSabinSurface& surface) {
  const int finest = FinestFor(surface);
  const std::vector<double> bounds = BoundsOf(surface, finest);
  ASSERT_EQ(bounds.size(), static_cast<std::size_t>(finest) + 1);
  const std::vector<Tessellation> levels = oracle::TessellationsOf(surface, finest);
  for (int k = 0; k + 2 < finest; ++k) {
    const auto at = static_cast<std::size_t>(k);
    for (const std::uint64_t seed : {1}) {
      const Measured measured = Measure(levels[at], levels.back(), seed);
      EXPECT_LE(measured.from_surface, bounds[at]) << "level " << k << ", seed " << seed;
      EXPECT_LE(measured.from_tessellation, bounds[at] + bounds.back())
          << "level " << k << ", seed " << seed;
    }
  }
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

TEST(ChordBound, HoldsOnRoughMeshes) {
  for (const MeshKind kind : AllMeshKinds()) {
    SCOPED_TRACE(MeshKindName(kind));
    ExpectWithinBounds(oracle::InterpolatingSurface(Generated(kind, 120)));
  }
}

TEST(ChordBound, HoldsOnOpenMeshes) {
  for (const std::string& name : oracle::OpenMeshNames()) {
    SCOPED_TRACE(name);
    ExpectWithinBounds(oracle::InterpolatingSurface(oracle::OpenMesh(name)));
  }
}

// Folds, and curves that turn back, as no interpolation makes them.
TEST(ChordBound, HoldsForRandomPoints) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    ExpectWithinBounds(oracle::RandomSurface(oracle::Dodecahedron(), seed));
    ExpectWithinBounds(oracle::RandomSurface(oracle::OpenMesh("HalfFan6"), seed));
    ExpectWithinBounds(oracle::RandomSurface(oracle::OpenMesh("TwoPatches"), seed));
  }
}

TEST(ChordBound, HoldsOnSmoothMeshes) {
  ExpectWithinBounds(oracle::SurfaceOf(oracle::RoundTorus(12, 8, 3, 1)));
  ExpectWithinBounds(oracle::SurfaceOf(oracle::CubeSphere(4)));
}

// Not more than a small multiple of what it bounds, at every level.
TEST(ChordBound, IsNotFarAboveTheDistance) {
  for (const PolygonMesh& mesh :
       {oracle::RoundTorus(16, 8, 3, 1), oracle::CubeSphere(4), oracle::Octahedron(),
        oracle::Dodecahedron(), oracle::OpenTube(9, 4), oracle::QuadPatch(4, 3)}) {
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
