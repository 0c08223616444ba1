// SPDX-License-Identifier: MIT
#include "proto/wire/samples.h"

#include <gtest/gtest.h>

#include <limits>

#include "engine/base/error.h"

namespace limn::wire {
namespace {

Reason ReasonOf(const absl::Status& status) {
  const auto detail = GetErrorDetail(status);
  EXPECT_TRUE(detail.has_value()) << "there is no error";
  return detail ? detail->reason : Reason::kInternal;
}

std::vector<SurfaceParameter> SomeParameters(std::size_t n) {
  std::vector<SurfaceParameter> parameters;
  for (std::size_t i = 0; i < n; ++i) {
    parameters.push_back(
        {static_cast<Index>(i), static_cast<Index>(3 * i), static_cast<double>(i) / 7, 0x1p-1074});
  }
  return parameters;
}

SampleArrays SomeSamples(std::size_t n, double size) {
  SampleArrays samples;
  samples.Resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double x = size * static_cast<double>(i + 1);
    samples.points[i] = {x, -x, x / 3};
    samples.du[i] = {2 * x, -0.0, x};
    samples.dv[i] = {x, 4 * x, 5e-324};
    samples.normals[i] = {0, 0.6, -0.8};
  }
  return samples;
}

TEST(Samples, ParametersComeBackAsTheyWere) {
  const std::vector<SurfaceParameter> parameters = SomeParameters(100);
  v1::ParameterBlock block;
  block.add_u(9);
  WriteParameters(parameters, &block);
  v1::ParameterBlock received;
  ASSERT_TRUE(received.ParseFromString(block.SerializeAsString()));
  ASSERT_TRUE(CheckParameters(received).ok());
  const std::vector<SurfaceParameter> all = ReadParameters(received, 0, 100);
  const std::vector<SurfaceParameter> some = ReadParameters(received, 90, 10);
  for (std::size_t i = 0; i < 100; ++i) {
    const SurfaceParameter& p = i < 90 ? all[i] : some[i - 90];
    EXPECT_EQ(p.face, parameters[i].face);
    EXPECT_EQ(p.corner, parameters[i].corner);
    EXPECT_EQ(p.u, parameters[i].u);
    EXPECT_EQ(p.v, parameters[i].v);
  }
}

TEST(Samples, ArraysOfUnequalLengthAreRefusedByName) {
  v1::ParameterBlock good;
  WriteParameters(SomeParameters(3), &good);
  const auto expect = [&](const char* field, auto spoil) {
    v1::ParameterBlock block = good;
    spoil(block);
    const absl::Status status = CheckParameters(block);
    EXPECT_EQ(ReasonOf(status), Reason::kMalformedRequest);
    EXPECT_EQ(GetErrorDetail(status)->field, field);
  };
  expect("parameters.corners", [](v1::ParameterBlock& b) { b.add_corners(1); });
  expect("parameters.corners", [](v1::ParameterBlock& b) { b.add_faces(1); });
  expect("parameters.u", [](v1::ParameterBlock& b) { b.mutable_u()->RemoveLast(); });
  expect("parameters.v", [](v1::ParameterBlock& b) { b.clear_v(); });
}

TEST(Samples, BlocksHaveALimit) {
  v1::ParameterBlock block;
  WriteParameters(SomeParameters(kMaxBlockParameters), &block);
  EXPECT_TRUE(CheckParameters(block).ok());
  WriteParameters(SomeParameters(kMaxBlockParameters + 1), &block);
  EXPECT_EQ(ReasonOf(CheckParameters(block)), Reason::kMalformedRequest);
  EXPECT_EQ(GetErrorDetail(CheckParameters(block))->field, "parameters");
  EXPECT_TRUE(CheckParameters({}).ok());
}

TEST(Samples, SamplesComeBackToTheBitInTheirOrder) {
  SampleArrays received;
  std::uint64_t first = 0;
  for (const std::size_t n : {3, 0, 1, 500}) {
    v1::EvaluateResponse message;
    EncodeSamples(SomeSamples(n, 1.0 / 3), first, &message);
    EXPECT_EQ(message.first(), first);
    EXPECT_EQ(message.ByteSizeLong() > n * kSampleBytes, true);
    ASSERT_TRUE(DecodeSamples(message, &received).ok());
    const SampleArrays sent = SomeSamples(n, 1.0 / 3);
    ASSERT_EQ(received.points.size(), first + n);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(received.points[first + i], sent.points[i]);
      EXPECT_EQ(received.du[first + i], sent.du[i]);
      EXPECT_EQ(received.dv[first + i], sent.dv[i]);
      EXPECT_EQ(received.normals[first + i], sent.normals[i]);
    }
    first += n;
  }
}

TEST(Samples, AnswersThatDoNotFitAreRefused) {
  const auto expect_refused = [](auto spoil) {
    v1::EvaluateResponse message;
    EncodeSamples(SomeSamples(4, 1), 0, &message);
    spoil(message);
    SampleArrays received;
    EXPECT_EQ(ReasonOf(DecodeSamples(message, &received)), Reason::kMalformedEncoding);
    EXPECT_TRUE(received.points.empty());
  };
  expect_refused([](v1::EvaluateResponse& m) { m.set_first(1); });
  expect_refused([](v1::EvaluateResponse& m) { m.mutable_normals()->pop_back(); });
  expect_refused([](v1::EvaluateResponse& m) { m.clear_derivatives_u(); });
  expect_refused([](v1::EvaluateResponse& m) { m.mutable_derivatives_v()->append(24, 'x'); });
  expect_refused([](v1::EvaluateResponse& m) {
    for (std::string* bytes : {m.mutable_positions(), m.mutable_derivatives_u(),
                               m.mutable_derivatives_v(), m.mutable_normals()}) {
      bytes->append(8, 'x');
    }
  });
}

}  // namespace
}  // namespace limn::wire
