// SPDX-License-Identifier: MIT
// Constraints that make no sense for a mesh are refused by the path of their field.
#include "engine/constraints/constraints.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <numeric>
#include <optional>
#include <string>

#include "engine/base/error.h"

namespace limn {
namespace {

constexpr Index kVertices = 8;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Vec3 kUp = {0, 0, 1};

struct BadConstraints {
  std::string name;
  Constraints constraints;
  Reason reason;
  std::string field;
  std::uint64_t index;
  // Stands in the message.
  std::string words;
};

void PrintTo(const BadConstraints& c, std::ostream* out) { *out << c.name; }

class BadConstraintsTest : public testing::TestWithParam<BadConstraints> {};

TEST_P(BadConstraintsTest, AreRefusedByFieldAndIndex) {
  const BadConstraints& bad = GetParam();
  const absl::Status status = ValidateConstraints(Context{}, bad.constraints, kVertices);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->reason, bad.reason) << status;
  EXPECT_EQ(detail->field, bad.field);
  EXPECT_EQ(detail->index, bad.index);
  EXPECT_FALSE(detail->remedy.empty());
  const std::string message(status.message());
  EXPECT_TRUE(message.starts_with(bad.field + ": ")) << message;
  EXPECT_NE(message.find(bad.words), std::string::npos) << message;
}

Constraints Subset(std::vector<Index> vertices) {
  Constraints constraints;
  constraints.interpolate = std::move(vertices);
  return constraints;
}
Constraints Normals(std::vector<NormalConstraint> normals) {
  Constraints constraints;
  constraints.normals = std::move(normals);
  return constraints;
}
Constraints Handles(std::vector<ShapeHandle> handles) {
  Constraints constraints;
  constraints.shape_handles = std::move(handles);
  return constraints;
}
Constraints NormalAtOtherVertex() {
  Constraints constraints = Subset({0, 1, 2});
  constraints.normals = {{1, kUp}, {3, kUp}};
  return constraints;
}
Constraints NormalWithoutVertices() {
  Constraints constraints = Subset({});
  constraints.normals = {{0, kUp}};
  return constraints;
}

std::vector<BadConstraints> Cases() {
  constexpr Reason kInvalid = Reason::kInvalidOption;
  constexpr Reason kRange = Reason::kIndexOutOfRange;
  const std::string handle = "constraints.shape_handles";
  return {
      {"SubsetOutOfRange", Subset({0, 8}), kRange, "constraints.interpolate.vertices[1]", 1,
       "there is no vertex 8, the mesh has 8"},
      {"SubsetLargestIndex", Subset({kNoIndex}), kRange, "constraints.interpolate.vertices[0]", 0,
       "4294967295"},
      {"SubsetRepeats", Subset({5, 2, 7, 2}), kInvalid, "constraints.interpolate.vertices[3]", 3,
       "vertex 2 is named before, at index 1"},
      {"NormalOutOfRange", Normals({{0, kUp}, {1, kUp}, {8, kUp}}), kRange,
       "constraints.normals[2].vertex", 2, "there is no vertex 8"},
      {"NormalRepeats", Normals({{4, kUp}, {3, kUp}, {4, -kUp}}), kInvalid,
       "constraints.normals[2].vertex", 2, "vertex 4 is named before, at index 0"},
      {"NormalZero", Normals({{0, kUp}, {4, {0, 0, 0}}}), kInvalid, "constraints.normals[1].normal",
       1, "zero"},
      {"NormalNegativeZero", Normals({{4, {-0.0, 0, 0}}}), kInvalid,
       "constraints.normals[0].normal", 0, "zero"},
      {"NormalNanX", Normals({{4, {kNan, 0, 1}}}), kInvalid, "constraints.normals[0].normal", 0,
       "not finite"},
      {"NormalNanZ", Normals({{4, {1, 0, kNan}}}), kInvalid, "constraints.normals[0].normal", 0,
       "not finite"},
      {"NormalInfinite", Normals({{4, {0, -kInfinity, 1}}}), kInvalid,
       "constraints.normals[0].normal", 0, "not finite"},
      {"NormalNotInterpolated", NormalAtOtherVertex(), kInvalid, "constraints.normals[1].vertex", 1,
       "vertex 3 is not interpolated"},
      {"NormalNothingInterpolated", NormalWithoutVertices(), kInvalid,
       "constraints.normals[0].vertex", 0, "vertex 0 is not interpolated"},
      {"HandleOutOfRange", Handles({{9, 1}}), kRange, handle + "[0].vertex", 0, "no vertex 9"},
      {"HandleRepeats", Handles({{1, 2}, {1, 2}}), kInvalid, handle + "[1].vertex", 1,
       "vertex 1 is named before, at index 0"},
      {"HandleZero", Handles({{1, 2}, {2, 0}}), kInvalid, handle + "[1].value", 1,
       "0 is not from 0.001 to 1000"},
      {"HandleTooSmall", Handles({{1, std::nextafter(kLeastHandle, 0)}}), kInvalid,
       handle + "[0].value", 0, "from 0.001 to 1000"},
      {"HandleTooLarge", Handles({{1, std::nextafter(kLargestHandle, 2 * kLargestHandle)}}),
       kInvalid, handle + "[0].value", 0, "from 0.001 to 1000"},
      {"HandleHuge", Handles({{1, 1e300}}), kInvalid, handle + "[0].value", 0, "1e+300"},
      {"HandleNegative", Handles({{1, -2}}), kInvalid, handle + "[0].value", 0, "-2"},
      {"HandleNan", Handles({{1, kNan}}), kInvalid, handle + "[0].value", 0, "nan"},
      {"HandleInfinite", Handles({{1, kInfinity}}), kInvalid, handle + "[0].value", 0, "inf"},
  };
}

INSTANTIATE_TEST_SUITE_P(Kinds, BadConstraintsTest, testing::ValuesIn(Cases()),
                         [](const auto& test) { return test.param.name; });

TEST(ConstraintsTest, NothingAskedIsValid) {
  EXPECT_TRUE(ValidateConstraints(Context{}, {}, kVertices).ok());
  EXPECT_TRUE(ValidateConstraints(Context{}, Subset({}), kVertices).ok());
  EXPECT_TRUE(ValidateConstraints(Context{}, {}, 0).ok());
}

TEST(ConstraintsTest, AnyOrderAnyLengthAndHandlesOfTheWholeRangeAreValid) {
  Constraints constraints = Subset({7, 0, 3});
  constraints.normals = {{3, {0, 0, 5e-324}}, {7, {-1e308, 1e308, 0}}};
  constraints.shape_handles = {{6, kLeastHandle}, {5, kLargestHandle}, {3, 1}};
  EXPECT_TRUE(ValidateConstraints(Context{}, constraints, kVertices).ok());
}

TEST(ConstraintsTest, WithoutASubsetNormalsMayStandAnywhere) {
  std::vector<NormalConstraint> normals;
  for (Index v = 0; v < kVertices; ++v) normals.push_back({kVertices - 1 - v, kUp});
  EXPECT_TRUE(ValidateConstraints(Context{}, Normals(normals), kVertices).ok());
}

TEST(ConstraintsTest, AnyConstraintOfAnEmptyMeshIsOutOfRange) {
  for (const Constraints& constraints : {Subset({0}), Normals({{0, kUp}}), Handles({{0, 1}})}) {
    const auto detail = GetErrorDetail(ValidateConstraints(Context{}, constraints, 0));
    ASSERT_TRUE(detail.has_value());
    EXPECT_EQ(detail->reason, Reason::kIndexOutOfRange);
  }
}

TEST(ConstraintsTest, StopsWhenAsked) {
  const Context cancelled;
  cancelled.Cancel();
  EXPECT_EQ(ValidateConstraints(cancelled, Subset({0}), kVertices).code(),
            absl::StatusCode::kCancelled);
  Context late;
  late.set_deadline(Context::Clock::now() - std::chrono::seconds(1));
  EXPECT_EQ(ValidateConstraints(late, Subset({0}), kVertices).code(),
            absl::StatusCode::kDeadlineExceeded);
}

// A repetition costs one more pass, not one for each entry.
TEST(ConstraintsTest, TakesLinearTimeForLongLists) {
  constexpr std::size_t kMany = 4'000'000;
  std::vector<Index> vertices(kMany);
  std::iota(vertices.begin(), vertices.end(), Index{0});
  Constraints constraints = Subset(vertices);
  for (const Index v : vertices) constraints.normals.push_back({v, kUp});
  for (const Index v : vertices) constraints.shape_handles.push_back({v, 2});
  EXPECT_TRUE(ValidateConstraints(Context{}, constraints, kMany).ok());
  constraints.shape_handles.back().vertex = 0;
  const auto detail = GetErrorDetail(ValidateConstraints(Context{}, constraints, kMany));
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->field, "constraints.shape_handles[3999999].vertex");
}

}  // namespace
}  // namespace limn
