// SPDX-License-Identifier: MIT
// Distances between limit surfaces and their tessellations, measured, to hold bounds against.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "engine/limit/chord_bound.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/tessellations.h"
#include "tests/oracle/triangle_tree.h"

namespace limn {

inline std::vector<double> BoundsOf(const DooSabinSurface& surface, int finest) {
  const absl::StatusOr<std::vector<double>> bounds = ChordBounds(Context(), surface, finest);
  EXPECT_TRUE(bounds.ok()) << bounds.status();
  return bounds.ok() ? *bounds : std::vector<double>();
}

// The deepest level that is looked at: T^finest stands for the surface. Its vertices lie on it.
inline int FinestFor(const DooSabinSurface& surface) {
  int finest = 4;
  std::size_t quads = 64 * surface.corners.size();
  while (finest < 7 && 4 * quads < 50'000) {
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
inline Measured Measure(const Tessellation& coarse, const Tessellation& fine, std::uint64_t seed) {
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

// surface: with its origin at 0.
inline void ExpectWithinBounds(const DooSabinSurface& surface) {
  const int finest = FinestFor(surface);
  const std::vector<double> bounds = BoundsOf(surface, finest);
  ASSERT_EQ(bounds.size(), static_cast<std::size_t>(finest) + 1);
  const std::vector<Tessellation> levels = oracle::TessellationsOf(surface, finest);
  for (int k = 0; k + 2 < finest; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const Measured measured = Measure(levels[at], levels.back(), 1);
    EXPECT_LE(measured.from_surface, bounds[at]) << "level " << k;
    EXPECT_LE(measured.from_tessellation, bounds[at] + bounds.back()) << "level " << k;
  }
  // Points of closed form too, at random parameters.
  std::mt19937_64 random(2);
  const oracle::Samples exact =
      oracle::Evaluated(surface, oracle::SomeParameters(surface.mesh, 5'000, 3));
  for (int k = 0; k <= finest; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const oracle::TriangleTree tree(oracle::SplitAtRandom(levels[at], &random));
    double largest = 0;
    for (const Vec3& p : exact.points) largest = std::max(largest, tree.Distance(p));
    EXPECT_LE(largest, bounds[at]) << "level " << k;
  }
}

}  // namespace limn
