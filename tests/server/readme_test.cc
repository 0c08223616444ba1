// SPDX-License-Identifier: MIT
// The README's table of limits is that of the server.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "server/limits.h"

namespace limn {
namespace {

// 16000000 -> "16,000,000".
std::string Grouped(std::uint64_t value) {
  std::string text = absl::StrCat(value);
  for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
  return text;
}

std::string DefaultText(const LimitEntry& entry) {
  const std::uint64_t value = ServerLimits{}.*entry.value;
  if (!entry.unit.starts_with("bytes")) return Grouped(value);
  const std::pair<int, const char*> units[] = {{30, "GiB"}, {20, "MiB"}, {10, "KiB"}};
  for (const auto& [bits, name] : units) {
    if (value % (std::uint64_t{1} << bits) == 0) return absl::StrCat(value >> bits, " ", name);
  }
  return Grouped(value);
}

// "Vertices of a mesh" -> "vertices of a mesh".
std::string Uncapitalized(std::string_view text) {
  std::string lower(text);
  lower[0] = absl::ascii_tolower(static_cast<unsigned char>(lower[0]));
  return lower;
}

TEST(ReadmeTest, ItsTableOfLimitsIsTheServers) {
  std::vector<std::string> expected;
  for (const LimitEntry& entry : LimitTable()) {
    expected.push_back(absl::StrCat("| `--", std::string(entry.name), "` | ", DefaultText(entry),
                                    " | ", Uncapitalized(entry.description), " |"));
  }
  std::vector<std::string> rows;
  std::ifstream readme(LIMN_README);
  bool in_table = false;
  for (std::string line; std::getline(readme, line);) {
    if (absl::StartsWith(line, "| flag | default |")) in_table = true;
    if (line.empty()) in_table = false;
    if (in_table && absl::StartsWith(line, "| `--")) rows.push_back(line);
  }
  EXPECT_EQ(rows, expected);
}

}  // namespace
}  // namespace limn
