// SPDX-License-Identifier: MIT
#include "engine/base/error.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>

#include "absl/status/statusor.h"

namespace limn {
namespace {

struct Expected {
  std::string_view name;
  absl::StatusCode code;
};

// The whole closed list, as the contract has it.
const std::map<Reason, Expected>& AllReasons() {
  static const auto* const kAll = new std::map<Reason, Expected>{
      {Reason::kInvalidOption, {"INVALID_OPTION", absl::StatusCode::kInvalidArgument}},
      {Reason::kIndexOutOfRange, {"INDEX_OUT_OF_RANGE", absl::StatusCode::kInvalidArgument}},
      {Reason::kEmptyMesh, {"EMPTY_MESH", absl::StatusCode::kInvalidArgument}},
      {Reason::kFaceTooSmall, {"FACE_TOO_SMALL", absl::StatusCode::kInvalidArgument}},
      {Reason::kRepeatedVertex, {"REPEATED_VERTEX", absl::StatusCode::kInvalidArgument}},
      {Reason::kNonFiniteCoordinate, {"NON_FINITE_COORDINATE", absl::StatusCode::kInvalidArgument}},
      {Reason::kCoordinateTooLarge, {"COORDINATE_TOO_LARGE", absl::StatusCode::kInvalidArgument}},
      {Reason::kExtentTooSmall, {"EXTENT_TOO_SMALL", absl::StatusCode::kInvalidArgument}},
      {Reason::kIsolatedVertex, {"ISOLATED_VERTEX", absl::StatusCode::kInvalidArgument}},
      {Reason::kNonManifoldEdge, {"NON_MANIFOLD_EDGE", absl::StatusCode::kInvalidArgument}},
      {Reason::kInconsistentOrientation,
       {"INCONSISTENT_ORIENTATION", absl::StatusCode::kInvalidArgument}},
      {Reason::kNonManifoldVertex, {"NON_MANIFOLD_VERTEX", absl::StatusCode::kInvalidArgument}},
      {Reason::kIllConditioned, {"ILL_CONDITIONED", absl::StatusCode::kInvalidArgument}},
      {Reason::kMalformedEncoding, {"MALFORMED_ENCODING", absl::StatusCode::kInvalidArgument}},
      {Reason::kMalformedRequest, {"MALFORMED_REQUEST", absl::StatusCode::kInvalidArgument}},
      {Reason::kMalformedFile, {"MALFORMED_FILE", absl::StatusCode::kInvalidArgument}},
      {Reason::kUnauthenticated, {"UNAUTHENTICATED", absl::StatusCode::kUnauthenticated}},
      {Reason::kLimitExceeded, {"LIMIT_EXCEEDED", absl::StatusCode::kResourceExhausted}},
      {Reason::kOutOfMemory, {"OUT_OF_MEMORY", absl::StatusCode::kResourceExhausted}},
      {Reason::kCancelled, {"CANCELLED", absl::StatusCode::kCancelled}},
      {Reason::kDeadlineExceeded, {"DEADLINE_EXCEEDED", absl::StatusCode::kDeadlineExceeded}},
      {Reason::kChecksumMismatch, {"CHECKSUM_MISMATCH", absl::StatusCode::kDataLoss}},
      {Reason::kUnimplemented, {"UNIMPLEMENTED", absl::StatusCode::kUnimplemented}},
      {Reason::kShuttingDown, {"SHUTTING_DOWN", absl::StatusCode::kUnavailable}},
      {Reason::kUnreachable, {"UNREACHABLE", absl::StatusCode::kUnavailable}},
      {Reason::kInternal, {"INTERNAL", absl::StatusCode::kInternal}},
  };
  return *kAll;
}

TEST(Error, EveryReasonHasItsNameAndCode) {
  // The list above is whole: values run from 0 to the last without a gap.
  EXPECT_EQ(AllReasons().size(), static_cast<std::size_t>(Reason::kInternal) + 1);
  std::set<std::string_view> names;
  for (const auto& [reason, expected] : AllReasons()) {
    EXPECT_EQ(ReasonName(reason), expected.name);
    EXPECT_EQ(CodeOf(reason), expected.code) << expected.name;
    names.insert(ReasonName(reason));
  }
  EXPECT_EQ(names.size(), AllReasons().size());
}

TEST(Error, DetailsComeBackAsTheyWereGiven) {
  for (const auto& [reason, expected] : AllReasons()) {
    for (const ErrorDetail& detail :
         {ErrorDetail{.reason = reason},
          ErrorDetail{.reason = reason, .field = "mesh.faces", .index = 0, .remedy = "Do, so: it"},
          ErrorDetail{.reason = reason, .index = ~std::uint64_t{0}},
          ErrorDetail{.reason = reason, .field = "solve.tolerance"},
          ErrorDetail{.reason = reason, .remedy = "Two\nlines", .limit = "max-level"},
          ErrorDetail{.reason = reason, .remedy = "Wait", .retryable = true}}) {
      const absl::Status status = MakeError("what happened", detail);
      EXPECT_EQ(status.code(), expected.code);
      const auto back = GetErrorDetail(status);
      ASSERT_TRUE(back.has_value());
      EXPECT_EQ(back->reason, detail.reason);
      EXPECT_EQ(back->field, detail.field);
      EXPECT_EQ(back->index, detail.index);
      EXPECT_EQ(back->remedy, detail.remedy);
      EXPECT_EQ(back->limit, detail.limit);
      EXPECT_EQ(back->retryable, detail.retryable);
    }
  }
}

TEST(Error, RemedyIsPartOfTheMessage) {
  EXPECT_EQ(MakeError("it is bad", {.remedy = "Mend it"}).message(), "it is bad. Mend it");
  EXPECT_EQ(MakeError("it is bad", {}).message(), "it is bad");
}

TEST(Error, DetailsSurviveCopies) {
  const absl::Status status = MakeError("x", {.reason = Reason::kNonManifoldEdge, .index = 3});
  const absl::StatusOr<int> wrapped = status;
  EXPECT_EQ(GetErrorDetail(wrapped.status())->index, 3U);
  EXPECT_EQ(GetErrorDetail(wrapped.status())->reason, Reason::kNonManifoldEdge);
}

TEST(Error, OkHasNoDetail) { EXPECT_FALSE(GetErrorDetail(absl::OkStatus()).has_value()); }

TEST(Error, StatusesOfOthersGetTheirCodesDetail) {
  const std::map<absl::StatusCode, Reason> expected = {
      {absl::StatusCode::kInvalidArgument, Reason::kMalformedRequest},
      {absl::StatusCode::kResourceExhausted, Reason::kLimitExceeded},
      {absl::StatusCode::kCancelled, Reason::kCancelled},
      {absl::StatusCode::kDeadlineExceeded, Reason::kDeadlineExceeded},
      {absl::StatusCode::kDataLoss, Reason::kChecksumMismatch},
      {absl::StatusCode::kUnimplemented, Reason::kUnimplemented},
      {absl::StatusCode::kUnauthenticated, Reason::kUnauthenticated},
      {absl::StatusCode::kUnavailable, Reason::kUnreachable},
      {absl::StatusCode::kInternal, Reason::kInternal},
      {absl::StatusCode::kNotFound, Reason::kInternal},
      {absl::StatusCode::kUnknown, Reason::kInternal},
  };
  for (const auto& [code, reason] : expected) {
    const auto detail = GetErrorDetail(absl::Status(code, "of others"));
    ASSERT_TRUE(detail.has_value());
    EXPECT_EQ(ReasonName(detail->reason), ReasonName(reason));
    EXPECT_EQ(detail->field, "");
    EXPECT_FALSE(detail->index.has_value());
  }
}

absl::StatusOr<int> Half(int value) {
  if (value % 2 != 0) return MakeError("odd", {.reason = Reason::kInvalidOption});
  return value / 2;
}

absl::StatusOr<int> Quarter(int value) {
  LIMN_ASSIGN_OR_RETURN(const int half, Half(value));
  LIMN_ASSIGN_OR_RETURN(const int quarter, Half(half));
  return quarter;
}

absl::Status CheckHalf(int value) {
  LIMN_RETURN_IF_ERROR(Half(value).status());
  return absl::CancelledError("came this far");
}

TEST(Error, MacrosHandErrorsOn) {
  EXPECT_EQ(*Quarter(12), 3);
  EXPECT_EQ(GetErrorDetail(Quarter(6).status())->reason, Reason::kInvalidOption);
  EXPECT_EQ(CheckHalf(3).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(CheckHalf(4).code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace limn
