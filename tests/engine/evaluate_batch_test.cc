// SPDX-License-Identifier: MIT
// Batches of parameters: what is refused, what is written, threads, cancelling.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "engine/limit/evaluate.h"
#include "engine/mesh/generate.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/expect.h"

namespace limn {
namespace {

using oracle::ExpectError;
using oracle::Samples;

class EvaluateBatchTest : public testing::Test {
 protected:
  EvaluateBatchTest()
      : surface_(oracle::RandomSurface(
            *GenerateMesh({.kind = MeshKind::kIrregularSphere, .vertices = 200, .seed = 3}), 51)) {
    std::mt19937_64 random(52);
    std::uniform_real_distribution<double> coordinate(0, 1);
    for (int i = 0; i < 20'000; ++i) {
      const auto h = static_cast<Index>(random() % surface_.mesh.half_edge_count());
      const double u = coordinate(random);
      parameters_.push_back(oracle::AtHalfEdge(surface_.mesh, h, u, coordinate(random)));
    }
  }

  absl::Status Evaluate(const Context& context = {}) {
    Samples samples(parameters_.size());
    return EvaluateSurface(context, surface_, parameters_, samples.Spans());
  }

  const Context context_;
  const DooSabinSurface surface_;
  std::vector<SurfaceParameter> parameters_;
};

TEST_F(EvaluateBatchTest, SameBitsForAnyNumberOfThreads) {
  const auto with = [&](int threads) {
    return oracle::WithThreads(threads, [&] { return oracle::Evaluated(surface_, parameters_); });
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

TEST_F(EvaluateBatchTest, EachAnswerDependsOnItsParameterAlone) {
  const Samples all = oracle::Evaluated(surface_, parameters_);
  for (std::size_t i = 0; i < parameters_.size(); i += 997) {
    const Samples one = oracle::Evaluated(surface_, {parameters_[i]});
    EXPECT_EQ(one.points[0], all.points[i]);
    EXPECT_EQ(one.du[0], all.du[i]);
    EXPECT_EQ(one.dv[0], all.dv[i]);
    EXPECT_EQ(one.normals[0], all.normals[i]);
  }
}

TEST_F(EvaluateBatchTest, WritesOnlyWhatIsAskedFor) {
  const Samples all = oracle::Evaluated(surface_, parameters_);
  const std::vector<Vec3> Samples::*const kinds[] = {&Samples::points, &Samples::du, &Samples::dv,
                                                     &Samples::normals};
  for (std::size_t kind = 0; kind < 4; ++kind) {
    std::vector<Vec3> values(parameters_.size());
    SurfaceSamples spans;
    absl::Span<Vec3>* const span[] = {&spans.points, &spans.du, &spans.dv, &spans.normals};
    *span[kind] = absl::MakeSpan(values);
    ASSERT_TRUE(EvaluateSurface(context_, surface_, parameters_, spans).ok());
    EXPECT_EQ(values, all.*kinds[kind]) << kind;
  }
  EXPECT_TRUE(EvaluateSurface(context_, surface_, parameters_, {}).ok());
}

TEST_F(EvaluateBatchTest, NoParametersAreNoError) {
  parameters_.clear();
  EXPECT_TRUE(Evaluate().ok());
}

TEST_F(EvaluateBatchTest, RefusesFacesThatAreNotThere) {
  for (const Index face : {static_cast<Index>(surface_.mesh.face_count()), kNoIndex}) {
    parameters_[700].face = face;
    ExpectError(Evaluate(), {Reason::kIndexOutOfRange, "parameters[700].face", 700});
  }
}

TEST_F(EvaluateBatchTest, RefusesCornersThatTheFaceHasNot) {
  SurfaceParameter& p = parameters_[7];
  const Index arity = surface_.mesh.face_begin()[p.face + 1] - surface_.mesh.face_begin()[p.face];
  for (const Index corner : {arity, kNoIndex}) {
    p.corner = corner;
    ExpectError(Evaluate(), {Reason::kIndexOutOfRange, "parameters[7].corner", 7});
  }
  p.corner = arity - 1;
  EXPECT_TRUE(Evaluate().ok());
}

TEST_F(EvaluateBatchTest, RefusesCoordinatesOutsideTheSquare) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad :
       {-0x1p-1074, -1.0, std::nextafter(1.0, 2.0), 2.0, infinity, -infinity, std::nan("")}) {
    SCOPED_TRACE(bad);
    const SurfaceParameter good = parameters_[19'999];
    parameters_[19'999].u = bad;
    ExpectError(Evaluate(), {Reason::kInvalidOption, "parameters[19999].u", 19'999});
    parameters_[19'999] = good;
    parameters_[19'999].v = bad;
    ExpectError(Evaluate(), {Reason::kInvalidOption, "parameters[19999].v", 19'999});
    parameters_[19'999] = good;
  }
  // A zero has no side.
  parameters_[0].u = -0.0;
  EXPECT_TRUE(Evaluate().ok());
}

TEST_F(EvaluateBatchTest, NamesTheFirstOfSeveralWrongOnesAndItsNumberInTheWhole) {
  for (const std::size_t i : {19'000, 12'345, 6'000, 301}) parameters_[i].v = 2;
  LIMN_ASSERT_OK_AND_ASSIGN(const SurfaceEvaluator evaluator,
                            SurfaceEvaluator::Create(context_, surface_));
  for (const int threads : {1, 8}) {
    oracle::WithThreads(threads, [&] {
      ExpectError(Evaluate(), {Reason::kInvalidOption, "parameters[301].v", 301});
      ExpectError(evaluator.Evaluate(context_, parameters_, {}, 10'000'000'000),
                  {Reason::kInvalidOption, "parameters[10000000301].v", 10'000'000'301});
    });
  }
}

TEST_F(EvaluateBatchTest, EndsWhenTheJobIsCancelledOrLate) {
  const Context cancelled;
  cancelled.Cancel();
  ExpectError(Evaluate(cancelled), {Reason::kCancelled});
  Context late;
  late.set_deadline(Context::Clock::now());
  ExpectError(Evaluate(late), {Reason::kDeadlineExceeded});
  LIMN_ASSERT_OK_AND_ASSIGN(const SurfaceEvaluator evaluator,
                            SurfaceEvaluator::Create(context_, surface_));
  ExpectError(evaluator.Evaluate(cancelled, parameters_, {}), {Reason::kCancelled});
}

// Evaluating once in each patch of a hub must not walk around it each time.
TEST(EvaluateHub, CostDoesNotGrowWithTheSidesOfTheFace) {
  const DooSabinSurface hub =
      oracle::RandomSurface(*GenerateMesh({.kind = MeshKind::kHub, .vertices = 200'000}), 53);
  std::vector<SurfaceParameter> parameters;
  for (Index h = 0; h < hub.mesh.half_edge_count(); ++h) {
    parameters.push_back(oracle::AtHalfEdge(hub.mesh, h, 1e-3, 1e-5));
  }
  std::vector<Vec3> points(parameters.size());
  // 600,000 parameters; walking around the two hubs for each would take minutes.
  Context context;
  context.set_deadline(Context::Clock::now() + std::chrono::seconds(30));
  EXPECT_TRUE(EvaluateSurface(context, hub, parameters, {.points = absl::MakeSpan(points)}).ok());
}

}  // namespace
}  // namespace limn
