// SPDX-License-Identifier: MIT
// Errors of the engine: absl::Status with a closed set of reasons and, for bad input, the field,
// the index and the remedy.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/status.h"

namespace limn {

// Why something was refused or failed. Each reason belongs to one status code; see CodeOf.
enum class Reason {
  // The caller's input: absl::StatusCode::kInvalidArgument.
  kInvalidOption,            // an option is out of its range
  kIndexOutOfRange,          // an index names a vertex or face that is not there
  kEmptyMesh,                // no vertices or no faces
  kFaceTooSmall,             // a face with fewer than three corners
  kRepeatedVertex,           // a face that visits a vertex twice
  kNonFiniteCoordinate,      // NaN or infinite
  kCoordinateTooLarge,       // arithmetic on it would overflow
  kExtentTooSmall,           // arithmetic on differences would underflow
  kIsolatedVertex,           // a vertex that no face uses
  kNonManifoldEdge,          // an edge of more than two faces
  kInconsistentOrientation,  // two faces that walk an edge in the same direction
  kNonManifoldVertex,        // a vertex whose faces do not form one fan
  kIllConditioned,           // the equations are singular or nearly so
  kMalformedEncoding,        // bytes that do not decode
  kMalformedRequest,         // messages out of order, missing or contradictory
  kMalformedFile,            // a file that does not parse
  kUnauthenticated,          // kUnauthenticated: no credentials, or none that count
  // The caller's limits.
  kLimitExceeded,     // kResourceExhausted: larger than a configured limit
  kOutOfMemory,       // kResourceExhausted: the system has no more
  kCancelled,         // kCancelled
  kDeadlineExceeded,  // kDeadlineExceeded
  kChecksumMismatch,  // kDataLoss: the bytes are not those that were sent
  kUnimplemented,     // kUnimplemented: in the contract, not built
  kShuttingDown,      // kUnavailable: the server is stopping
  kUnreachable,       // kUnavailable: no server answers
  kInternal,          // kInternal: a defect of Limn
};

// The reason's name in UPPER_SNAKE_CASE, such as "NON_MANIFOLD_EDGE". Never empty.
std::string_view ReasonName(Reason reason);

// The status code that errors of this reason carry.
absl::StatusCode CodeOf(Reason reason);

// What an error says beside its message.
struct ErrorDetail {
  Reason reason = Reason::kInternal;
  // Path of the offending field, such as "faces", "solve.tolerance" or, within an element,
  // "constraints.normals[3].vertex"; empty when there is none.
  std::string field = {};
  // Index of the first offending element in that field, if it has elements.
  std::optional<std::uint64_t> index = std::nullopt;
  // What the caller can do about it, one sentence; empty when there is nothing.
  std::string remedy = {};
  // The limit that was exceeded, as the server's flag is called, such as "max-vertices"; empty when
  // there is none that can be set.
  std::string limit = {};
  // Whether the same request may go well a little later because nothing is wrong with it: others
  // use what it needs. Always taken as true with kUnavailable.
  bool retryable = false;
};

// An error with a message for a person and its detail as payload. The remedy is appended to the
// message. Thread-safe.
[[nodiscard]] absl::Status MakeError(std::string_view message, const ErrorDetail& detail);

// The detail of an error made by MakeError; for any other non-ok status the detail is derived from
// its code; nothing for an ok status. Thread-safe.
[[nodiscard]] std::optional<ErrorDetail> GetErrorDetail(const absl::Status& status);

}  // namespace limn

// Returns from the calling function if `expr` (an absl::Status) is an error.
#define LIMN_RETURN_IF_ERROR(expr)                              \
  do {                                                          \
    if (absl::Status limn_status = (expr); !limn_status.ok()) { \
      return limn_status;                                       \
    }                                                           \
  } while (false)

#define LIMN_CONCAT_INNER(a, b) a##b
#define LIMN_CONCAT(a, b) LIMN_CONCAT_INNER(a, b)

// Evaluates `expr` (an absl::StatusOr), returns from the calling function if it is an error, and
// moves the value into `lhs` (a declaration or an lvalue) otherwise.
#define LIMN_ASSIGN_OR_RETURN(lhs, expr) \
  LIMN_ASSIGN_OR_RETURN_IMPL(LIMN_CONCAT(limn_statusor_, __LINE__), lhs, expr)
#define LIMN_ASSIGN_OR_RETURN_IMPL(statusor, lhs, expr)    \
  auto statusor = (expr);                                  \
  if (!statusor.ok()) return std::move(statusor).status(); \
  lhs = *std::move(statusor)
