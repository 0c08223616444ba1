// SPDX-License-Identifier: MIT
#include "engine/base/error.h"

#include <array>
#include <string>
#include <vector>

#include "absl/strings/cord.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace limn {
namespace {

// Payload: reason, field, index, limit, "retry" or nothing, and remedy, one a line. Only the remedy
// may have line breaks.
constexpr char kPayloadUrl[] = "limn/error_detail";

struct ReasonEntry {
  Reason reason;
  std::string_view name;
  absl::StatusCode code;
};

constexpr std::array kReasons = {
    ReasonEntry{Reason::kInvalidOption, "INVALID_OPTION", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kIndexOutOfRange, "INDEX_OUT_OF_RANGE", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kEmptyMesh, "EMPTY_MESH", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kFaceTooSmall, "FACE_TOO_SMALL", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kRepeatedVertex, "REPEATED_VERTEX", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kNonFiniteCoordinate, "NON_FINITE_COORDINATE",
                absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kCoordinateTooLarge, "COORDINATE_TOO_LARGE",
                absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kExtentTooSmall, "EXTENT_TOO_SMALL", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kIsolatedVertex, "ISOLATED_VERTEX", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kNonManifoldEdge, "NON_MANIFOLD_EDGE", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kInconsistentOrientation, "INCONSISTENT_ORIENTATION",
                absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kNonManifoldVertex, "NON_MANIFOLD_VERTEX",
                absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kIllConditioned, "ILL_CONDITIONED", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kMalformedEncoding, "MALFORMED_ENCODING",
                absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kMalformedRequest, "MALFORMED_REQUEST", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kMalformedFile, "MALFORMED_FILE", absl::StatusCode::kInvalidArgument},
    ReasonEntry{Reason::kUnauthenticated, "UNAUTHENTICATED", absl::StatusCode::kUnauthenticated},
    ReasonEntry{Reason::kLimitExceeded, "LIMIT_EXCEEDED", absl::StatusCode::kResourceExhausted},
    ReasonEntry{Reason::kOutOfMemory, "OUT_OF_MEMORY", absl::StatusCode::kResourceExhausted},
    ReasonEntry{Reason::kCancelled, "CANCELLED", absl::StatusCode::kCancelled},
    ReasonEntry{Reason::kDeadlineExceeded, "DEADLINE_EXCEEDED",
                absl::StatusCode::kDeadlineExceeded},
    ReasonEntry{Reason::kChecksumMismatch, "CHECKSUM_MISMATCH", absl::StatusCode::kDataLoss},
    ReasonEntry{Reason::kUnimplemented, "UNIMPLEMENTED", absl::StatusCode::kUnimplemented},
    ReasonEntry{Reason::kShuttingDown, "SHUTTING_DOWN", absl::StatusCode::kUnavailable},
    ReasonEntry{Reason::kUnreachable, "UNREACHABLE", absl::StatusCode::kUnavailable},
    ReasonEntry{Reason::kInternal, "INTERNAL", absl::StatusCode::kInternal},
};

Reason ReasonOfCode(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kInvalidArgument:
      return Reason::kMalformedRequest;
    case absl::StatusCode::kUnauthenticated:
      return Reason::kUnauthenticated;
    case absl::StatusCode::kResourceExhausted:
      return Reason::kLimitExceeded;
    case absl::StatusCode::kCancelled:
      return Reason::kCancelled;
    case absl::StatusCode::kDeadlineExceeded:
      return Reason::kDeadlineExceeded;
    case absl::StatusCode::kDataLoss:
      return Reason::kChecksumMismatch;
    case absl::StatusCode::kUnimplemented:
      return Reason::kUnimplemented;
    case absl::StatusCode::kUnavailable:
      return Reason::kUnreachable;
    default:
      return Reason::kInternal;
  }
}

}  // namespace

std::string_view ReasonName(Reason reason) {
  for (const ReasonEntry& entry : kReasons) {
    if (entry.reason == reason) return entry.name;
  }
  return "INTERNAL";
}

absl::StatusCode CodeOf(Reason reason) {
  for (const ReasonEntry& entry : kReasons) {
    if (entry.reason == reason) return entry.code;
  }
  return absl::StatusCode::kInternal;
}

absl::Status MakeError(std::string_view message, const ErrorDetail& detail) {
  std::string text(message);
  if (!detail.remedy.empty()) absl::StrAppend(&text, ". ", detail.remedy);
  absl::Status status(CodeOf(detail.reason), text);
  status.SetPayload(kPayloadUrl,
                    absl::Cord(absl::StrCat(
                        std::string(ReasonName(detail.reason)), "\n", detail.field, "\n",
                        detail.index.has_value() ? absl::StrCat(*detail.index) : "", "\n",
                        detail.limit, "\n", detail.retryable ? "retry" : "", "\n", detail.remedy)));
  return status;
}

std::optional<ErrorDetail> GetErrorDetail(const absl::Status& status) {
  if (status.ok()) return std::nullopt;
  ErrorDetail detail;
  detail.reason = ReasonOfCode(status.code());
  const auto payload = status.GetPayload(kPayloadUrl);
  if (!payload.has_value()) return detail;
  const std::string text(*payload);
  const std::vector<std::string> lines = absl::StrSplit(text, absl::MaxSplits('\n', 5));
  if (lines.size() != 6) return detail;
  for (const ReasonEntry& entry : kReasons) {
    if (entry.name == lines[0]) detail.reason = entry.reason;
  }
  detail.field = lines[1];
  if (std::uint64_t index = 0; absl::SimpleAtoi(lines[2], &index)) detail.index = index;
  detail.limit = lines[3];
  detail.retryable = !lines[4].empty();
  detail.remedy = lines[5];
  return detail;
}

}  // namespace limn
