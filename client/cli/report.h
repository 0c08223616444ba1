// SPDX-License-Identifier: MIT
// A job's summary, for a person and for a program.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "limn/v1/interpolate.pb.h"

namespace limn::cli {

// A short table: sizes, what was repaired, sweeps, errors, time per stage, bytes on the wire.
[[nodiscard]] std::string SummaryTable(const v1::Summary& summary);

// The JSON mapping of limn.v1.Summary, indented, every field written; but the mapping of a repair,
// originalVertex and originalFace, as lists of numbers.
[[nodiscard]] absl::StatusOr<std::string> SummaryJson(const v1::Summary& summary);

// 1234567 as "1,234,567".
[[nodiscard]] std::string WithCommas(std::uint64_t value);

}  // namespace limn::cli
