// SPDX-License-Identifier: MIT
// Batches of parameters of Catmull-Clark and Loop surfaces: what is refused, what is written,
// threads, cancelling; surfaces that are none.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/limit/evaluate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/primal_surface.h"

namespace limn {
namespace {

using oracle::Creases;
using oracle::Evaluated;
using oracle::ExpectError;
using oracle::PrimalSurfaceOf;
using oracle::Rule;
using oracle::Samples;

class EvaluatePrimalBatchTest : public testing::TestWithParam<Rule> {
 protected:
  EvaluatePrimalBatchTest() : given_(Given()), surface_(PrimalSurfaceOf(given_, GetParam(), {})) {
    std::mt19937_64 random(52);
    std::uniform_real_distribution<double> coordinate(0, 1);
    for (int i = 0; i < 10'000; ++i) {
      const auto face = static_cast<Index>(random() % given_.face_count());
      const auto corner = static_cast<Index>(random() % given_.arity(face));
      const double u = coordinate(random);
      const double v = coordinate(random);
      parameters_.push_back({face, corner, u, Loop() ? v * (1 - u) : v});
    }
  }
  static bool Loop() { return GetParam() == Rule::kLoop; }
  static PolygonMesh Given() {
    const PolygonMesh mesh =
        *GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 200, .seed = 3});
    return Loop() ? oracle::Triangulated(mesh) : mesh;
  }
  absl::Status Evaluate(const Context& context = {}) {
    Samples samples(parameters_.size());
    return EvaluateSurface(context, surface_, parameters_, samples.Spans());
  }

  const PolygonMesh given_;
  const PrimalSurface surface_;
  std::vector<SurfaceParameter> parameters_;
};

TEST_P(EvaluatePrimalBatchTest, SameBitsForAnyNumberOfThreads) {
  const auto with = [&](int threads) {
    return oracle::WithThreads(threads, [&] { return Evaluated(surface_, parameters_); });
  };
  const Samples one = with(1);
  for (const int threads : {2, 8}) {
    const Samples many = with(threads);
    EXPECT_EQ(one.points, many.points);
    EXPECT_EQ(one.du, many.du);
    EXPECT_EQ(one.dv, many.dv);
    EXPECT_EQ(one.normals, many.normals);
  }
}

TEST_P(EvaluatePrimalBatchTest, EachAnswerDependsOnItsParameterAlone) {
  const Samples all = Evaluated(surface_, parameters_);
  for (std::size_t i = 0; i < parameters_.size(); i += 997) {
    const Samples one = Evaluated(surface_, {parameters_[i]});
    EXPECT_EQ(one.points[0], all.points[i]);
    EXPECT_EQ(one.du[0], all.du[i]);
    EXPECT_EQ(one.dv[0], all.dv[i]);
    EXPECT_EQ(one.normals[0], all.normals[i]);
  }
}

TEST_P(EvaluatePrimalBatchTest, WritesOnlyWhatIsAskedFor) {
  const Samples all = Evaluated(surface_, parameters_);
  std::vector<Vec3> values(parameters_.size());
  ASSERT_TRUE(
      EvaluateSurface(Context(), surface_, parameters_, {.points = absl::MakeSpan(values)}).ok());
  EXPECT_EQ(values, all.points);
  ASSERT_TRUE(
      EvaluateSurface(Context(), surface_, parameters_, {.normals = absl::MakeSpan(values)}).ok());
  EXPECT_EQ(values, all.normals);
  ASSERT_TRUE(EvaluateSurface(Context(), surface_, parameters_, {}).ok());
}

TEST_P(EvaluatePrimalBatchTest, PointsAreInTheModelsFrame) {
  PrimalSurface moved = PrimalSurfaceOf(given_, GetParam(), {});
  moved.origin = {100, -200, 300};
  const Samples here = Evaluated(surface_, parameters_);
  const Samples there = Evaluated(moved, parameters_);
  for (std::size_t i = 0; i < parameters_.size(); i += 101) {
    EXPECT_EQ(there.points[i], here.points[i] + moved.origin);
    EXPECT_EQ(there.normals[i], here.normals[i]);
  }
}

TEST_P(EvaluatePrimalBatchTest, NamesTheFirstParameterThatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto faces = static_cast<Index>(given_.face_count());
  const std::vector<std::pair<SurfaceParameter, std::pair<Reason, std::string>>> wrong = {
      {{faces, 0, 0, 0}, {Reason::kIndexOutOfRange, "face"}},
      {{0, static_cast<Index>(given_.arity(0)), 0, 0}, {Reason::kIndexOutOfRange, "corner"}},
      {{0, 0, -1e-300, 0}, {Reason::kInvalidOption, "u"}},
      {{0, 0, 0, 1.0000001}, {Reason::kInvalidOption, "v"}},
      {{0, 0, nan, 0}, {Reason::kInvalidOption, "u"}},
      {{0, 0, 0, nan}, {Reason::kInvalidOption, "v"}}};
  for (const auto& [parameter, error] : wrong) {
    std::vector<SurfaceParameter> kept = parameters_;
    parameters_[7777] = parameter;
    parameters_[9000].u = 2;
    ExpectError(Evaluate(), {error.first, "parameters[7777]." + error.second, 7777});
    parameters_ = kept;
  }
}

TEST_P(EvaluatePrimalBatchTest, TrianglesEndAtTheirThirdSide) {
  parameters_ = {{0, 0, 0.5, 0.5}, {1, 2, 0.25, 0.75}, {2, 1, 1, 0}, {2, 1, 0.7, 0.31}};
  if (Loop()) {
    ExpectError(Evaluate(), {Reason::kInvalidOption, "parameters[3].v", 3});
  } else {
    EXPECT_TRUE(Evaluate().ok());
  }
  parameters_.pop_back();
  EXPECT_TRUE(Evaluate().ok());
}

// 1 - 0.9 is below 0.1 as doubles are, and so on.
TEST_P(EvaluatePrimalBatchTest, SumsOfOneAreInTheTriangleThoughTheyAreRounded) {
  if (!Loop()) return;
  parameters_ = {{0, 0, 0.1, 0.9}, {0, 1, 0.9, 0}, {0, 0, 0.8, 0.2}, {0, 1, 0.2, 0}};
  ASSERT_LT(1 - parameters_[0].v, parameters_[0].u);
  const Samples samples = Evaluated(surface_, parameters_);
  // From the second corner u is what v was from the first.
  EXPECT_LE(MaxAbs(samples.points[0] - samples.points[1]), 1e-15);
  EXPECT_LE(MaxAbs(samples.points[2] - samples.points[3]), 1e-15);
}

TEST_P(EvaluatePrimalBatchTest, EndsWhenTheJobIsCancelled) {
  const Context context;
  context.Cancel();
  ExpectError(Evaluate(context), {Reason::kCancelled});
  ExpectError(SurfaceEvaluator::Create(context, surface_).status(), {Reason::kCancelled});
}

INSTANTIATE_TEST_SUITE_P(All, EvaluatePrimalBatchTest,
                         testing::Values(Rule::kCatmullClark, Rule::kLoop),
                         [](const testing::TestParamInfo<Rule>& scheme) {
                           return scheme.param == Rule::kLoop ? "Loop" : "CatmullClark";
                         });

// One refinement is linear in the valence, and all corners of a hub's triangles ask for it.
TEST(EvaluatePrimal, HubsAreNoTrouble) {
  const PolygonMesh given = oracle::DoublePyramid(2000);
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    const PrimalSurface surface = PrimalSurfaceOf(given, rule, {});
    std::vector<SurfaceParameter> parameters;
    for (Index f = 0; f < 20; ++f) {
      for (Index c = 0; c < 3; ++c) parameters.push_back({f, c, 1e-6, 2e-6});
    }
    const Samples samples = Evaluated(surface, parameters);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      EXPECT_TRUE(IsFinite(samples.points[i]));
      EXPECT_NEAR(Norm(samples.normals[i]), 1, 1e-14);
    }
  }
}

TEST(PrimalSurface, RefusesWhatDoesNotFit) {
  const HalfEdgeMesh mesh = oracle::BuildOrDie(oracle::Cube());
  const Sharpness sharpness;
  const std::vector<Vec3> points(7);
  ExpectError(MakeCatmullClarkSurface(Context(), {mesh, sharpness}, points).status(),
              {Reason::kInternal});
  ExpectError(MakeLoopSurface(oracle::BuildOrDie(oracle::Cube()), {}, Buffer<Vec3>(8)).status(),
              {Reason::kInvalidOption, "mesh.faces", 0});
  ExpectError(
      MakeLoopSurface(oracle::BuildOrDie(oracle::Octahedron()), {}, Buffer<Vec3>(7)).status(),
      {Reason::kInternal});
  const Context cancelled;
  cancelled.Cancel();
  ExpectError(MakeCatmullClarkSurface(cancelled, {mesh, sharpness}, std::vector<Vec3>(8)).status(),
              {Reason::kCancelled});
}

}  // namespace
}  // namespace limn
