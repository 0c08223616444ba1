// SPDX-License-Identifier: MIT
// See status.h.
#include "proto/wire/status.h"

#include <algorithm>
#include <optional>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn::wire {
namespace {

constexpr std::string_view kDomain = "limn";
constexpr std::string_view kErrorInfoUrl = "type.googleapis.com/google.rpc.ErrorInfo";
constexpr std::string_view kBadRequestUrl = "type.googleapis.com/google.rpc.BadRequest";
constexpr std::string_view kRetryInfoUrl = "type.googleapis.com/google.rpc.RetryInfo";
constexpr std::size_t kMaxText = 512;

// Trailers of more than 8 KiB are dropped by peers, and proto strings must be UTF-8.
std::string Trailer(std::string_view text) {
  std::string safe(text.substr(0, kMaxText));
  for (char& c : safe) {
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';
  }
  return safe;
}

template <class Message>
void AddDetail(std::string_view url, const Message& message, v1::RichStatus* rich) {
  google::protobuf::Any* any = rich->add_details();
  any->set_type_url(std::string(url));
  message.SerializeToString(any->mutable_value());
}

v1::ErrorDetails MakeErrorInfo(const ErrorDetail& detail, std::string_view request_id) {
  v1::ErrorDetails info;
  info.set_reason(std::string(ReasonName(detail.reason)));
  info.set_domain(std::string(kDomain));
  auto& metadata = *info.mutable_metadata();
  if (!detail.field.empty()) metadata["field"] = Trailer(detail.field);
  if (!request_id.empty()) metadata["request_id"] = Trailer(request_id);
  if (detail.index.has_value()) metadata["index"] = absl::StrCat(*detail.index);
  if (!detail.remedy.empty()) metadata["remedy"] = Trailer(detail.remedy);
  if (detail.reason == Reason::kLimitExceeded) {
    const std::string& limit = detail.limit.empty() ? detail.field : detail.limit;
    if (!limit.empty()) metadata["limit"] = Trailer(limit);
  }
  return info;
}

v1::BadRequestDetails MakeBadRequest(const ErrorDetail& detail, const std::string& message) {
  v1::BadRequestDetails bad;
  v1::BadRequestDetails::FieldViolation* violation = bad.add_field_violations();
  std::string path = Trailer(detail.field);
  // "constraints.normals[3].vertex" says the index already.
  const bool names_index = path.find('[') != std::string::npos;
  if (detail.index.has_value() && !names_index) absl::StrAppend(&path, "[", *detail.index, "]");
  violation->set_field(path);
  violation->set_description(Trailer(message));
  return bad;
}

bool MayPassByItself(const ErrorDetail& detail) {
  return detail.retryable || CodeOf(detail.reason) == absl::StatusCode::kUnavailable;
}

std::optional<Reason> ReasonFromName(std::string_view name) {
  for (int i = 0; i <= static_cast<int>(Reason::kInternal); ++i) {
    const Reason reason = static_cast<Reason>(i);
    if (ReasonName(reason) == name) return reason;
  }
  return std::nullopt;
}

bool HasRetryInfo(const v1::RichStatus& rich) {
  return std::any_of(rich.details().begin(), rich.details().end(),
                     [](const auto& any) { return any.type_url() == kRetryInfoUrl; });
}

// What our own ErrorInfo says; nothing for another program's.
std::optional<ErrorDetail> ReadErrorInfo(const v1::RichStatus& rich) {
  for (const google::protobuf::Any& any : rich.details()) {
    v1::ErrorDetails info;
    if (any.type_url() != kErrorInfoUrl || !info.ParseFromString(any.value())) continue;
    if (info.domain() != kDomain) continue;
    const std::optional<Reason> reason = ReasonFromName(info.reason());
    if (!reason.has_value()) continue;
    const auto text = [&](const char* key) {
      const auto found = info.metadata().find(key);
      return found == info.metadata().end() ? std::string() : found->second;
    };
    ErrorDetail detail{.reason = *reason, .field = text("field"), .remedy = text("remedy")};
    if (std::uint64_t index = 0; absl::SimpleAtoi(text("index"), &index)) detail.index = index;
    if (text("limit") != detail.field) detail.limit = text("limit");
    detail.retryable = HasRetryInfo(rich);
    return detail;
  }
  return std::nullopt;
}

absl::StatusCode KnownCode(int code) {
  return code >= 0 && code <= 16 ? static_cast<absl::StatusCode>(code) : absl::StatusCode::kUnknown;
}

absl::Status Restore(absl::StatusCode code, std::string message, const v1::RichStatus& rich) {
  const std::optional<ErrorDetail> detail = ReadErrorInfo(rich);
  if (!detail.has_value() || CodeOf(detail->reason) != code) return absl::Status(code, message);
  // MakeError will append the remedy again.
  const std::string tail = absl::StrCat(". ", detail->remedy);
  if (!detail->remedy.empty() && message.ends_with(tail)) {
    message.resize(message.size() - tail.size());
  }
  return MakeError(message, *detail);
}

}  // namespace

v1::RichStatus ToRichStatus(const absl::Status& status, std::string_view request_id) {
  v1::RichStatus rich;
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail.has_value()) return rich;
  rich.set_code(static_cast<int>(status.code()));
  rich.set_message(Trailer(std::string(status.message())));
  AddDetail(kErrorInfoUrl, MakeErrorInfo(*detail, request_id), &rich);
  if (status.code() == absl::StatusCode::kInvalidArgument) {
    AddDetail(kBadRequestUrl, MakeBadRequest(*detail, std::string(status.message())), &rich);
  }
  if (MayPassByItself(*detail)) {
    v1::RetryDetails retry;
    retry.mutable_retry_delay()->set_seconds(kRetryDelaySeconds);
    AddDetail(kRetryInfoUrl, retry, &rich);
  }
  return rich;
}

grpc::Status ToGrpcStatus(const absl::Status& status, std::string_view request_id) {
  if (status.ok()) return grpc::Status::OK;
  const v1::RichStatus rich = ToRichStatus(status, request_id);
  return grpc::Status(static_cast<grpc::StatusCode>(rich.code()), rich.message(),
                      rich.SerializeAsString());
}

absl::Status FromRichStatus(const v1::RichStatus& status) {
  if (status.code() == 0) return absl::OkStatus();
  return Restore(KnownCode(status.code()), status.message(), status);
}

absl::Status FromGrpcStatus(const grpc::Status& status) {
  if (status.ok()) return absl::OkStatus();
  v1::RichStatus rich;
  if (!rich.ParseFromString(status.error_details())) rich.Clear();
  return Restore(KnownCode(status.error_code()), status.error_message(), rich);
}

}  // namespace limn::wire
