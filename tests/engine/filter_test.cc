// SPDX-License-Identifier: MIT
// Filtering by the terms of the interpolation series.
#include "engine/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "engine/interpolate.h"
#include "tests/engine/allocation_meter.h"
#include "tests/oracle/creased_level.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::ExpectError;

class FilterTest : public testing::TestWithParam<std::tuple<Scheme, std::string>> {
 protected:
  FilterTest() {
    const oracle::Rule rule =
        options_.scheme == Scheme::kLoop ? oracle::Rule::kLoop : oracle::Rule::kCatmullClark;
    mesh_ = oracle::Jittered(oracle::MeshFor(rule, std::get<1>(GetParam())), 5, 0.1);
    size_ = static_cast<double>(oracle::Diagonal(oracle::FromVec3(mesh_.positions)));
  }

  Buffer<Vec3> Run(const FilterOptions& filter, const PolygonMesh& mesh) const {
    absl::StatusOr<Buffer<Vec3>> points = Filter(Context(), mesh, filter, options_);
    EXPECT_TRUE(points.ok()) << points.status();
    return *std::move(points);
  }
  Buffer<Vec3> Run(const FilterOptions& filter) const { return Run(filter, mesh_); }

  // A, as the whole pipeline has it: limit points of the mesh as a control mesh.
  Buffer<Vec3> LimitPoints(const PolygonMesh& mesh) const {
    InterpolateOptions options = options_;
    options.level = 0;
    options.constraints.interpolate.emplace();
    const absl::StatusOr<InterpolateResult> result = Interpolate(Context(), mesh, options);
    EXPECT_TRUE(result.ok()) << result.status();
    return result->surface.positions;
  }

  void ExpectNear(const Buffer<Vec3>& a, const Buffer<Vec3>& b, double tolerance) const {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t v = 0; v < a.size(); ++v) {
      ASSERT_LE(Norm(a[v] - b[v]), tolerance * size_) << v;
    }
  }

  InterpolateOptions options_ = {.scheme = std::get<0>(GetParam())};
  PolygonMesh mesh_;
  double size_ = 0;
};

TEST_P(FilterTest, GainsOfOneGiveTheMeshBack) {
  ExpectNear(Run({.gains = {1, 1, 1, 1, 1}, .rest = 1}), mesh_.positions, 1e-14);
}

TEST_P(FilterTest, TheFirstTermIsTheLimitPoints) {
  ExpectNear(Run({.gains = {1}, .rest = 0}), LimitPoints(mesh_), 1e-14);
}

// Each term by itself, from the pipeline's limit points: M_(i+1) = M_i - A M_i.
TEST_P(FilterTest, TermsAreThoseOfTheSeries) {
  PolygonMesh rest = mesh_;
  const Buffer<Vec3> first = LimitPoints(mesh_);
  std::vector<Vec3> sum(mesh_.vertex_count());
  const std::vector<double> gains = {1, 0.5, -2, 3};
  for (const double gain : gains) {
    const Buffer<Vec3> limits = LimitPoints(rest);
    for (std::size_t v = 0; v < sum.size(); ++v) {
      sum[v] += gain * limits[v];
      rest.positions[v] -= limits[v];
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) sum[v] += 0.25 * rest.positions[v];
  ExpectNear(Run({.gains = gains, .rest = 0.25}), Buffer<Vec3>(sum.begin(), sum.end()), 1e-13);
}

// [CC]: the sum of the first terms, each filtered, tends to the mesh whose limit points are M.
TEST_P(FilterTest, MoreTermsAreNearerToTheMesh) {
  double before = std::numeric_limits<double>::infinity();
  for (const std::size_t terms : {1U, 4U, 16U, 64U}) {
    const Buffer<Vec3> points = Run({.gains = std::vector<double>(terms, 1), .rest = 0});
    double sum = 0;
    for (std::size_t v = 0; v < points.size(); ++v) {
      const double distance = Norm(points[v] - mesh_.positions[v]);
      sum += distance * distance;
    }
    EXPECT_LE(sum, (1 + 1e-12) * before);
    before = sum;
  }
}

TEST_P(FilterTest, TheFilterGoesWithTheMeshWhereverItIs) {
  const FilterOptions filter = {.gains = {0.5, 2}, .rest = 1.5};
  const Buffer<Vec3> here = Run(filter);
  const Vec3 way = {0x1p20 * size_, -0x1p19 * size_, size_};
  const Buffer<Vec3> there = Run(filter, oracle::Moved(mesh_, 1, way));
  for (std::size_t v = 0; v < here.size(); ++v) {
    // What is left of the bits so far away.
    ASSERT_LE(Norm(there[v] - (here[v] + way)), 0x1p-49 * Norm(way));
  }
}

// Large enough for several chunks of work.
TEST_P(FilterTest, SameBitsForAnyNumberOfThreads) {
  const PolygonMesh torus = oracle::TorusOfTriangles(100, 90);
  const auto run = [&] { return Run({.gains = {1, 0.5}, .rest = 0.25}, torus); };
  EXPECT_EQ(oracle::WithThreads(1, run), oracle::WithThreads(4, run));
}

TEST_P(FilterTest, TheEstimateIsAnUpperBound) {
  const PolygonMesh torus = oracle::TorusOfTriangles(100, 90);
  const std::uint64_t estimate =
      EstimateFilterBytes(torus.vertex_count(), torus.face_count(), torus.corner_count(), options_);
  const AllocationMeter meter;
  Run({.gains = {1, 0.5}, .rest = 0.25}, torus);
  EXPECT_LE(meter.peak(), estimate);
  EXPECT_LE(estimate, 3 * meter.peak());
}

std::string NameOf(const testing::TestParamInfo<std::tuple<Scheme, std::string>>& info) {
  const Scheme scheme = std::get<0>(info.param);
  const std::string name = scheme == Scheme::kDooSabin       ? "DooSabin_"
                           : scheme == Scheme::kCatmullClark ? "CatmullClark_"
                                                             : "Loop_";
  return name + std::get<1>(info.param);
}
INSTANTIATE_TEST_SUITE_P(
    All, FilterTest,
    testing::Combine(testing::Values(Scheme::kDooSabin, Scheme::kCatmullClark, Scheme::kLoop),
                     testing::Values("cube", "torus_jittered_seed_5", "ngons_seed_2",
                                     "TubeOfOneRing", "CubeWithoutLid", "TwoPatches")),
    NameOf);

TEST(FilterErrors, EveryBadFilterNamesItsField) {
  const PolygonMesh mesh = oracle::ClosedMesh("cube");
  const auto expect = [&](const FilterOptions& filter, const InterpolateOptions& surface,
                          const std::string& field) {
    ExpectError(ValidateFilter(filter, surface), {Reason::kInvalidOption, field});
  };
  const double nan = std::nan("");
  expect({}, {}, "filter.gains");
  expect({.gains = std::vector<double>(kMostGains + 1, 1)}, {}, "filter.gains");
  expect({.gains = {1, nan}}, {}, "filter.gains[1]");
  expect({.gains = {1}, .rest = std::numeric_limits<double>::infinity()}, {}, "filter.rest");
  expect({.gains = {1}}, {.constraints = {.interpolate = std::vector<Index>{1}}},
         "constraints.interpolate");
  expect({.gains = {1}}, {.constraints = {.normals = {{0, {0, 0, 1}}}}}, "constraints.normals");
  expect({.gains = {1}}, {.constraints = {.shape_handles = {{0, 2}}}}, "constraints.shape_handles");
  expect({.gains = {1}}, {.scheme = Scheme::kCatmullClark, .rule = FirstRule::kBilinear},
         "solve.rule");
  expect({.gains = {1}}, {.constraints = {.corners = {{0, 1}}}}, "constraints.corners");
  ExpectError(Filter(Context(), mesh, {.gains = {1e300}}, {}).status(),
              {Reason::kInvalidOption, "filter.gains"});
}

TEST(FilterErrors, LimitsAndCancelAreHeard) {
  const PolygonMesh mesh = oracle::ClosedMesh("genus_three");
  ExpectError(Filter(Context(Limits{.max_bytes = 100}), mesh, {.gains = {1}}, {}).status(),
              {Reason::kLimitExceeded, "mesh"});
  const Context context;
  context.Cancel();
  ExpectError(Filter(context, mesh, {.gains = {1}}, {}).status(), {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
