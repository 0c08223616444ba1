// SPDX-License-Identifier: MIT
// What the whole job refuses, how much memory it takes, and how it stops.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/interpolate.h"
#include "engine/mesh/generate.h"
#include "tests/engine/allocation_meter.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/slowdown.h"

namespace limn {
namespace {

using oracle::ExpectError;
using std::chrono::milliseconds;

PolygonMesh Generated(MeshKind kind, std::uint64_t vertices) {
  auto mesh = GenerateMesh({.kind = kind, .vertices = vertices, .seed = 6});
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  return *std::move(mesh);
}

absl::Status Refusal(const PolygonMesh& mesh, const InterpolateOptions& options = {},
                     const Limits& limits = {}) {
  return Interpolate(Context(limits), mesh, options).status();
}

TEST(InterpolateLimits, RefusesWhatIsNoManifold) {
  for (const oracle::BrokenMesh& broken : oracle::BrokenMeshes()) {
    SCOPED_TRACE(broken.name);
    ExpectError(Refusal(broken.mesh), {broken.reason, broken.field, broken.first});
  }
  ExpectError(Refusal({}), {Reason::kEmptyMesh, "mesh.vertices"});
}

TEST(InterpolateLimits, RefusesCoordinatesThatArithmeticCannotTake) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {std::nan(""), infinity, -infinity}) {
    PolygonMesh mesh = oracle::Cube();
    mesh.positions[5].y = bad;
    ExpectError(Refusal(mesh), {Reason::kNonFiniteCoordinate, "mesh.vertices", 5});
  }
  for (const double bad : {1e308, -1e308, 1e101}) {
    PolygonMesh mesh = oracle::Cube();
    mesh.positions[6].z = bad;
    ExpectError(Refusal(mesh), {Reason::kCoordinateTooLarge, "mesh.vertices", 6});
  }
}

TEST(InterpolateLimits, ChordTolerancesAreDooSabins) {
  ExpectError(Refusal(oracle::Cube(), {.scheme = Scheme::kCatmullClark, .chord_tolerance = 0.1}),
              {Reason::kUnimplemented, "surface.chord_tolerance"});
}

TEST(InterpolateLimits, ChordTolerancesThatNeedTooMuchAreRefusedByName) {
  const PolygonMesh cube = oracle::Cube();
  for (const double tolerance : {0.0, -1.0, std::nan("")}) {
    ExpectError(Refusal(cube, {.chord_tolerance = tolerance}),
                {Reason::kInvalidOption, "surface.chord_tolerance"});
  }
  ExpectError(Refusal(cube, {.chord_tolerance = 1e-3, .finest = 2}),
              {Reason::kLimitExceeded, "surface.chord_tolerance"});
  Limits limits;
  limits.max_bytes = EstimateBytes(8, 6, 24, {.level = 2});
  const Context context(limits);
  ExpectError(Interpolate(context, cube, {.chord_tolerance = 1e-3}).status(),
              {Reason::kLimitExceeded, "surface.chord_tolerance"});
}

TEST(InterpolateLimits, RefusesOptionsOutOfRange) {
  const PolygonMesh cube = oracle::Cube();
  ExpectError(Refusal(cube, {.solve = {.tolerance = std::nan("")}}),
              {Reason::kInvalidOption, "solve.tolerance"});
  ExpectError(Refusal(cube, {.solve = {.max_sweeps = 10001}}),
              {Reason::kInvalidOption, "solve.max_sweeps"});
  ExpectError(Refusal(cube, {.level = 11}), {Reason::kInvalidOption, "surface.level"});
  ExpectError(Refusal(cube, {.level = 4}, {.max_level = 3}),
              {Reason::kInvalidOption, "surface.level"});
  ExpectError(Refusal(cube, {.level = ~0U}), {Reason::kInvalidOption, "surface.level"});
  EXPECT_TRUE(Refusal(cube, {.level = 3}, {.max_level = 3}).ok());
  // Without a surface its level does not matter.
  EXPECT_TRUE(Refusal(cube, {.level = 99, .surface = false}).ok());
}

TEST(InterpolateLimits, RefusesWhatExceedsTheLimitsBeforeAllocating) {
  const PolygonMesh mesh = Generated(MeshKind::kIrregularSphere, 5000);
  struct Case {
    std::string field;
    InterpolateOptions options;
    Limits limits;
  };
  const std::uint64_t bytes =
      EstimateBytes(mesh.vertex_count(), mesh.face_count(), mesh.corner_count(), {});
  const Case cases[] = {
      {"mesh.vertices", {}, {.max_vertices = 4999}},
      {"mesh.corners", {}, {.max_corners = mesh.corner_count() - 1}},
      {"surface.level", {}, {.max_bytes = bytes - 1}},
      // More half-edges than their numbers can count, whatever the memory.
      {"surface.level",
       {.level = 12},
       {.max_level = 30, .max_bytes = std::numeric_limits<std::uint64_t>::max()}},
      {"surface.level",
       {.level = 30},
       {.max_level = 30, .max_bytes = std::numeric_limits<std::uint64_t>::max()}},
  };
  for (const Case& refused : cases) {
    SCOPED_TRACE(absl::StrCat(refused.field, ", level ", refused.options.level));
    const AllocationMeter meter;
    const absl::Status status = Refusal(mesh, refused.options, refused.limits);
    EXPECT_LE(meter.peak(), 16384U);
    ExpectError(status, {Reason::kLimitExceeded, refused.field});
    EXPECT_NE(GetErrorDetail(status)->remedy, "");
  }
  EXPECT_TRUE(
      Refusal(mesh, {},
              {.max_vertices = 5000, .max_corners = mesh.corner_count(), .max_bytes = bytes})
          .ok());
}

TEST(InterpolateLimits, EstimateIsAnUpperBoundWithinAFactorOfTwo) {
  for (const MeshKind kind : AllMeshKinds()) {
    if (!IsClosedKind(kind)) continue;
    const PolygonMesh mesh = Generated(kind, 20000 / oracle::kSlowdown);
    std::vector<InterpolateOptions> all;
    for (const std::uint32_t level : {0U, 1U, 2U, 3U}) {
      all.push_back({.level = level});
      all.push_back({.level = level, .normals = false});
    }
    all.push_back({.surface = false});
    all.push_back({.solve = {.method = SolveMethod::kJacobi}, .surface = false});
    all.push_back({.solve = {.method = SolveMethod::kGaussSeidel}, .surface = false});
    for (const InterpolateOptions& options : all) {
      for (const int threads : {1, 2}) {
        SCOPED_TRACE(absl::StrCat(std::string(MeshKindName(kind)), ", level ", options.level,
                                  ", surface ", options.surface, ", normals ", options.normals,
                                  ", method ", static_cast<int>(options.solve.method)));
        const std::uint64_t estimate =
            EstimateBytes(mesh.vertex_count(), mesh.face_count(), mesh.corner_count(), options);
        const std::size_t peak = oracle::WithThreads(threads, [&] {
          const AllocationMeter meter;
          EXPECT_TRUE(Refusal(mesh, options).ok());
          return meter.peak();
        });
        EXPECT_LE(peak, estimate);
        EXPECT_LE(estimate, 2 * peak);
      }
    }
  }
}

TEST(InterpolateLimits, EstimateIsAnUpperBoundForTheOtherSchemesToo) {
  const PolygonMesh polygons = Generated(MeshKind::kIrregularSphere, 20000 / oracle::kSlowdown);
  const PolygonMesh triangles = oracle::Triangulated(polygons);
  std::vector<InterpolateOptions> all;
  for (const Scheme scheme : {Scheme::kCatmullClark, Scheme::kLoop}) {
    for (const std::uint32_t level : {0U, 1U, 2U}) {
      all.push_back({.scheme = scheme, .level = level});
    }
    all.push_back({.scheme = scheme, .surface = false});
    all.push_back(
        {.scheme = scheme, .solve = {.method = SolveMethod::kConjugateGradient}, .surface = false});
    const Index a = polygons.corner_vertex[0];
    const Index b = polygons.corner_vertex[1];
    all.push_back({.scheme = scheme,
                   .constraints = {.creases = {{{a, b}, {2.5F}}}, .holes = {3}},
                   .level = 1});
  }
  all.push_back({.scheme = Scheme::kCatmullClark, .rule = FirstRule::kBilinear, .level = 0});
  // Surfaces that are kept, and normals everywhere.
  for (const Scheme scheme : {Scheme::kCatmullClark, Scheme::kLoop}) {
    for (const std::uint32_t level : {0U, 1U, 2U}) {
      all.push_back({.scheme = scheme, .level = level, .keep_patches = true});
    }
    all.push_back({.scheme = scheme, .surface = false, .keep_patches = true});
    for (const std::uint32_t level : {0U, 2U}) {
      InterpolateOptions& options = all.emplace_back(all.front());
      options.scheme = scheme;
      options.level = level;
      options.keep_patches = level == 0;
      for (Index v = 0; v < polygons.vertex_count(); ++v) {
        options.constraints.normals.push_back({v, polygons.positions[v]});
      }
    }
  }
  for (const std::uint32_t level : {0U, 1U, 2U}) {
    all.push_back(
        {.constraints = {.features = FeatureValues{.default_edge = 0.3}}, .level = level});
  }
  for (const InterpolateOptions& options : all) {
    SCOPED_TRACE(absl::StrCat(static_cast<int>(options.scheme), ", level ", options.level,
                              ", surface ", options.surface, ", creases ",
                              options.constraints.creases.size(), ", kept ", options.keep_patches,
                              ", normals ", options.constraints.normals.size()));
    const PolygonMesh& mesh = options.scheme == Scheme::kLoop ? triangles : polygons;
    const std::uint64_t estimate =
        EstimateBytes(mesh.vertex_count(), mesh.face_count(), mesh.corner_count(), options);
    const AllocationMeter meter;
    ASSERT_TRUE(Refusal(mesh, options).ok());
    EXPECT_LE(meter.peak(), estimate);
    EXPECT_LE(estimate, 3 * meter.peak());
  }
}

// A mesh of which every face is plane is cut along all edges.
TEST(InterpolateLimits, EstimateHoldsForPlaneFaces) {
  PolygonMesh mesh = Generated(MeshKind::kCube, 20000);
  for (const FaceKind most : {FaceKind::kPlane, FaceKind::kSurface}) {
    for (const std::uint32_t level : {0U, 1U, 2U, 3U}) {
      FeatureValues values = {.default_face = most, .default_edge = 0.3};
      values.faces = {{5, FaceKind::kPlane}};
      const InterpolateOptions options = {.constraints = {.features = values}, .level = level};
      const AllocationMeter meter;
      const absl::Status status = Refusal(mesh, options);
      ASSERT_TRUE(status.ok()) << status;
      EXPECT_LE(meter.peak(), EstimateBytes(mesh.vertex_count(), mesh.face_count(),
                                            mesh.corner_count(), options));
    }
  }
}

// Points that are moved to the origin are counted too.
TEST(InterpolateLimits, EstimateHoldsFarFromTheOrigin) {
  const PolygonMesh mesh =
      oracle::Moved(Generated(MeshKind::kIrregularSphere, 20000), 1, {1e6, 0, 0});
  for (const InterpolateOptions& options : {InterpolateOptions{}, InterpolateOptions{.level = 0},
                                            InterpolateOptions{.surface = false}}) {
    const AllocationMeter meter;
    ASSERT_TRUE(Refusal(mesh, options).ok());
    EXPECT_LE(meter.peak(),
              EstimateBytes(mesh.vertex_count(), mesh.face_count(), mesh.corner_count(), options));
  }
}

TEST(InterpolateLimits, EstimateGrowsAndSaturates) {
  EXPECT_EQ(EstimateBytes(~0ULL, ~0ULL, ~0ULL, {.level = 30}),
            std::numeric_limits<std::uint64_t>::max());
  std::uint64_t last = EstimateBytes(1000, 1000, 4000, {.surface = false});
  for (const std::uint32_t level : {1U, 2U, 5U, 10U, 16U}) {
    const std::uint64_t bytes = EstimateBytes(1000, 1000, 4000, {.level = level});
    EXPECT_GT(bytes, last);
    last = bytes;
  }
}

struct Stages {
  std::vector<std::string> order;
  std::vector<ProgressEvent> events;
  void Listen(Context* context) {
    context->set_progress([this](const ProgressEvent& event) {
      events.push_back(event);
      if (order.empty() || order.back() != event.stage) order.emplace_back(event.stage);
    });
  }
};

TEST(InterpolateLimits, StagesComeInTheirOrderWithGrowingProgress) {
  const std::vector<std::string> with_surface = {"build",   "solve",  "first_refinement",
                                                 "perturb", "refine", "limit"};
  const std::vector<std::string> without = {"build", "solve"};
  for (const bool surface : {true, false}) {
    Context context;
    Stages stages;
    stages.Listen(&context);
    const auto result = Interpolate(context, oracle::Cube(), {.level = 4, .surface = surface});
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(stages.order, surface ? with_surface : without);
    std::vector<std::string> timed;
    for (const StageTime& stage : result->stages) {
      timed.emplace_back(stage.stage);
      EXPECT_GE(stage.milliseconds, 0);
      EXPECT_LT(stage.milliseconds, 60000);
    }
    EXPECT_EQ(timed, stages.order);
    for (std::size_t i = 0; i < stages.events.size(); ++i) {
      EXPECT_GE(stages.events[i].fraction, 0);
      EXPECT_LE(stages.events[i].fraction, 1);
      if (i > 0 && stages.events[i].stage == stages.events[i - 1].stage) {
        EXPECT_GT(stages.events[i].fraction, stages.events[i - 1].fraction);
      }
    }
  }
}

TEST(InterpolateLimits, CancelEndsTheStageInWhichItComes) {
  const PolygonMesh mesh = Generated(MeshKind::kIrregularSphere, 5000);
  for (const std::string stage :
       {"build", "solve", "first_refinement", "perturb", "refine", "limit"}) {
    SCOPED_TRACE(stage);
    Context context;
    std::string last;
    context.set_progress([&](const ProgressEvent& event) {
      last = std::string(event.stage);
      if (event.stage == stage) context.Cancel();
    });
    ExpectError(Interpolate(context, mesh, {}).status(), {Reason::kCancelled});
    EXPECT_EQ(last, stage);
  }
}

TEST(InterpolateLimits, StoppedJobsDoNotStart) {
  const PolygonMesh cube = oracle::Cube();
  const Context cancelled;
  cancelled.Cancel();
  ExpectError(Interpolate(cancelled, cube, {}).status(), {Reason::kCancelled});
  Context late;
  late.set_deadline(Context::Clock::now());
  ExpectError(Interpolate(late, cube, {}).status(), {Reason::kDeadlineExceeded});
}

// Stops at moments all over a long job: each time the job ends in a small part of its time.
TEST(InterpolateLimits, CancelAndDeadlineEndTheJobSoon) {
  const PolygonMesh mesh = Generated(MeshKind::kIrregularSphere, 10000);
  const InterpolateOptions options = {.level = 4};
  const auto run = [&](const Context& context) {
    const auto begin = Context::Clock::now();
    const absl::Status status = Interpolate(context, mesh, options).status();
    return std::pair(status, Context::Clock::now() - begin);
  };
  auto whole = Context::Clock::duration::max();
  for (int i = 0; i < 3; ++i) {
    const auto [status, time] = run(Context());
    ASSERT_TRUE(status.ok()) << status;
    whole = std::min(whole, time);
  }
  const auto soon = whole / 4 + milliseconds(50);
  for (const int percent : {5, 20, 35, 50}) {
    SCOPED_TRACE(percent);
    const auto moment = whole * percent / 100;
    const Context context;
    std::thread other([&] {
      std::this_thread::sleep_for(moment);
      context.Cancel();
    });
    const auto [cancelled, cancel_time] = run(context);
    other.join();
    ExpectError(cancelled, {Reason::kCancelled});
    EXPECT_LT(cancel_time, moment + soon);

    Context late;
    late.set_deadline(Context::Clock::now() + moment);
    const auto [expired, deadline_time] = run(late);
    ExpectError(expired, {Reason::kDeadlineExceeded});
    EXPECT_LT(deadline_time, moment + soon);
  }
}

}  // namespace
}  // namespace limn
