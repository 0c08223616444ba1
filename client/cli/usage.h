// SPDX-License-Identifier: MIT
// What is wrong with a command line that cannot be understood.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Error.hpp>

namespace limn::cli {

// Of the known words the one that is most probably meant by `word`: one that begins with it, or
// that at most a third of its letters, and two at least, being wrong, missing, too many or swapped
// with their neighbours makes. Nothing when none is so near. Thread-safe.
[[nodiscard]] std::optional<std::string> NearestWord(std::string_view word,
                                                     const std::vector<std::string>& known);

// One sentence without an end: which word is not known, what it may have been meant to be, and else
// what CLI11 says. app: which the line was parsed by.
[[nodiscard]] std::string ExplainUsageError(const CLI::App& app, const CLI::ParseError& error);

}  // namespace limn::cli
