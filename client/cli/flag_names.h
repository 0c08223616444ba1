// SPDX-License-Identifier: MIT
// The contract's names in the words of the command line.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/status.h"

namespace limn::cli {

// The flag that sets this field of a job's header, such as "--level" for "surface.level"; empty for
// a field that no flag sets. Thread-safe.
[[nodiscard]] std::string_view FlagOf(std::string_view field);

// The message of a job's error in words of the command line: the flag instead of the field, or
// before the message where that does not name the field, and values as flags take them. status: not
// ok. Thread-safe.
[[nodiscard]] std::string MessageInFlags(const absl::Status& status);

}  // namespace limn::cli
