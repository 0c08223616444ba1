// SPDX-License-Identifier: MIT
// Errors on the wire: every detail survives the way there and back, and any client's stock library
// finds google.rpc details where it looks for them.
#include "proto/wire/status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>

#include "engine/base/error.h"

namespace limn::wire {
namespace {

constexpr int kReasons = static_cast<int>(Reason::kInternal) + 1;

// Type URL -> bytes of the details in a trailer.
std::map<std::string, std::string> Details(const grpc::Status& status) {
  v1::RichStatus rich;
  EXPECT_TRUE(rich.ParseFromString(status.error_details()));
  EXPECT_EQ(rich.code(), status.error_code());
  EXPECT_EQ(rich.message(), status.error_message());
  std::map<std::string, std::string> details;
  for (const auto& any : rich.details()) details[any.type_url()] = any.value();
  return details;
}

constexpr char kErrorInfo[] = "type.googleapis.com/google.rpc.ErrorInfo";
constexpr char kBadRequest[] = "type.googleapis.com/google.rpc.BadRequest";
constexpr char kRetryInfo[] = "type.googleapis.com/google.rpc.RetryInfo";

TEST(StatusTest, OkIsOk) {
  EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok());
  EXPECT_TRUE(FromGrpcStatus(grpc::Status::OK).ok());
  EXPECT_EQ(ToRichStatus(absl::OkStatus()).SerializeAsString(), "");
  EXPECT_TRUE(FromRichStatus(v1::RichStatus()).ok());
}

TEST(StatusTest, EveryReasonSurvivesWithAllItSays) {
  for (int i = 0; i < kReasons; ++i) {
    const ErrorDetail detail = {.reason = static_cast<Reason>(i),
                                .field = "constraints.normals",
                                .index = 3,
                                .remedy = "Give it a length"};
    const absl::Status sent = MakeError("a normal is zero", detail);
    for (const absl::Status& got :
         {FromGrpcStatus(ToGrpcStatus(sent)), FromRichStatus(ToRichStatus(sent))}) {
      EXPECT_EQ(got.code(), sent.code());
      EXPECT_EQ(got.message(), "a normal is zero. Give it a length");
      const auto back = GetErrorDetail(got);
      ASSERT_TRUE(back.has_value());
      EXPECT_EQ(ReasonName(back->reason), ReasonName(detail.reason));
      EXPECT_EQ(back->field, detail.field);
      EXPECT_EQ(back->index, detail.index);
      EXPECT_EQ(back->remedy, detail.remedy);
    }
  }
}

TEST(StatusTest, AbsentDetailsStayAbsent) {
  const auto got =
      FromGrpcStatus(ToGrpcStatus(MakeError("ends with a dot. ", {.reason = Reason::kInternal})));
  EXPECT_EQ(got.message(), "ends with a dot. ");
  const auto detail = GetErrorDetail(got);
  ASSERT_TRUE(detail.has_value());
  EXPECT_EQ(detail->field, "");
  EXPECT_FALSE(detail->index.has_value());
  EXPECT_EQ(detail->remedy, "");
}

TEST(StatusTest, BadInputCarriesErrorInfoAndBadRequest) {
  const grpc::Status status = ToGrpcStatus(MakeError(
      "face 7 names vertex 9",
      {.reason = Reason::kIndexOutOfRange, .field = "faces", .index = 7, .remedy = "Use less"}));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  const auto details = Details(status);
  EXPECT_EQ(details.size(), 2U);
  v1::ErrorDetails info;
  ASSERT_TRUE(info.ParseFromString(details.at(kErrorInfo)));
  EXPECT_EQ(info.reason(), "INDEX_OUT_OF_RANGE");
  EXPECT_EQ(info.domain(), "limn");
  const std::map<std::string, std::string> metadata(info.metadata().begin(), info.metadata().end());
  EXPECT_THAT(metadata,
              testing::ElementsAre(testing::Pair("field", "faces"), testing::Pair("index", "7"),
                                   testing::Pair("remedy", "Use less")));
  v1::BadRequestDetails bad;
  ASSERT_TRUE(bad.ParseFromString(details.at(kBadRequest)));
  ASSERT_EQ(bad.field_violations_size(), 1);
  EXPECT_EQ(bad.field_violations(0).field(), "faces[7]");
  EXPECT_EQ(bad.field_violations(0).description(), "face 7 names vertex 9. Use less");
}

TEST(StatusTest, APathThatNamesItsElementIsTheWholePath) {
  const grpc::Status status = ToGrpcStatus(MakeError(
      "constraints.normals[3].vertex: no vertex 9",
      {.reason = Reason::kIndexOutOfRange, .field = "constraints.normals[3].vertex", .index = 3}));
  v1::BadRequestDetails bad;
  ASSERT_TRUE(bad.ParseFromString(Details(status).at(kBadRequest)));
  ASSERT_EQ(bad.field_violations_size(), 1);
  EXPECT_EQ(bad.field_violations(0).field(), "constraints.normals[3].vertex");
  const auto back = GetErrorDetail(FromGrpcStatus(status));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->field, "constraints.normals[3].vertex");
  EXPECT_EQ(back->index, 3U);
}

TEST(StatusTest, OnlyWhatPassesByItselfCarriesRetryInfo) {
  for (int i = 0; i < kReasons; ++i) {
    const Reason reason = static_cast<Reason>(i);
    const auto details = Details(ToGrpcStatus(MakeError("x", {.reason = reason})));
    EXPECT_EQ(details.count(kErrorInfo), 1U);
    EXPECT_EQ(details.count(kBadRequest), CodeOf(reason) == absl::StatusCode::kInvalidArgument);
    EXPECT_EQ(details.count(kRetryInfo), CodeOf(reason) == absl::StatusCode::kUnavailable);
  }
  const grpc::Status full = ToGrpcStatus(
      MakeError("the queue is full",
                {.reason = Reason::kLimitExceeded, .limit = "queue-length", .retryable = true}));
  const auto queue = Details(full);
  EXPECT_TRUE(GetErrorDetail(FromGrpcStatus(full))->retryable);
  v1::RetryDetails retry;
  ASSERT_TRUE(retry.ParseFromString(queue.at(kRetryInfo)));
  EXPECT_EQ(retry.retry_delay().seconds(), kRetryDelaySeconds);
  // The name of a field says nothing about it.
  for (const std::string field : {"mesh.vertex_count", "queue"}) {
    const grpc::Status size =
        ToGrpcStatus(MakeError("too large", {.reason = Reason::kLimitExceeded, .field = field}));
    EXPECT_EQ(Details(size).count(kRetryInfo), 0U);
    EXPECT_FALSE(GetErrorDetail(FromGrpcStatus(size))->retryable);
    v1::ErrorDetails info;
    ASSERT_TRUE(info.ParseFromString(Details(size).at(kErrorInfo)));
    EXPECT_EQ(info.metadata().at("limit"), field);
  }
}

TEST(StatusTest, ALimitIsNamedBesideTheField) {
  const grpc::Status sent = ToGrpcStatus(MakeError(
      "too fine",
      {.reason = Reason::kLimitExceeded, .field = "surface.level", .limit = "max-level"}));
  v1::ErrorDetails info;
  ASSERT_TRUE(info.ParseFromString(Details(sent).at(kErrorInfo)));
  EXPECT_EQ(info.metadata().at("field"), "surface.level");
  EXPECT_EQ(info.metadata().at("limit"), "max-level");
  const std::optional<ErrorDetail> back = GetErrorDetail(FromGrpcStatus(sent));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->field, "surface.level");
  EXPECT_EQ(back->limit, "max-level");
}

TEST(StatusTest, OtherProgramsStatusIsKeptWithItsCode) {
  for (int code = 1; code <= 16; ++code) {
    const auto got = FromGrpcStatus(grpc::Status(static_cast<grpc::StatusCode>(code), "theirs"));
    EXPECT_EQ(static_cast<int>(got.code()), code);
    EXPECT_EQ(got.message(), "theirs");
  }
  const auto garbage = FromGrpcStatus(
      grpc::Status(grpc::StatusCode::UNAVAILABLE, "theirs", std::string("\xff\x00garbage", 9)));
  EXPECT_EQ(garbage.code(), absl::StatusCode::kUnavailable);
  v1::RichStatus unknown;
  unknown.set_code(99);
  EXPECT_EQ(FromRichStatus(unknown).code(), absl::StatusCode::kUnknown);
}

TEST(StatusTest, OtherProgramsDetailsAreNotTakenForOurs) {
  const auto receive = [](const std::string& reason, const std::string& domain) {
    v1::ErrorDetails info;
    info.set_reason(reason);
    info.set_domain(domain);
    v1::RichStatus rich;
    rich.set_code(5);
    rich.set_message("theirs");
    auto* any = rich.add_details();
    any->set_type_url(kErrorInfo);
    any->set_value(info.SerializeAsString());
    return FromGrpcStatus(
        grpc::Status(grpc::StatusCode::NOT_FOUND, "theirs", rich.SerializeAsString()));
  };
  // Another domain; a reason that a later version may have; a reason of another code.
  for (const auto& got : {receive("INTERNAL", "example.com"), receive("NEW_REASON", "limn"),
                          receive("OPEN_MESH", "limn")}) {
    EXPECT_EQ(got.code(), absl::StatusCode::kNotFound);
    EXPECT_EQ(got.message(), "theirs");
  }
}

TEST(StatusTest, AStatusWithoutDetailGetsTheReasonOfItsCode) {
  const auto details = Details(ToGrpcStatus(absl::CancelledError("stopped")));
  v1::ErrorDetails info;
  ASSERT_TRUE(info.ParseFromString(details.at(kErrorInfo)));
  EXPECT_EQ(info.reason(), "CANCELLED");
}

TEST(StatusTest, LongAndForeignTextFitsATrailer) {
  const std::string text = std::string(100'000, 'x') + "\xff\xfe";
  const grpc::Status status = ToGrpcStatus(MakeError(
      text, {.reason = Reason::kMalformedFile, .field = text, .index = 1, .remedy = text}));
  EXPECT_LE(status.error_message().size() + status.error_details().size(), 4U << 10);
  const grpc::Status bytes =
      ToGrpcStatus(MakeError("caf\xe9 \xc3\xa9", {.reason = Reason::kInternal}));
  EXPECT_EQ(bytes.error_message(), "caf? ??");
}

}  // namespace
}  // namespace limn::wire
