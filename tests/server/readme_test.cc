// SPDX-License-Identifier: MIT
// The README's table of limits is that of the server.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
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
  if (entry.name == "max-connection-age" && value == 0) return "never";
  if (!entry.unit.starts_with("bytes")) return Grouped(value);
  const std::pair<int, const char*> units[] = {{30, "GiB"}, {20, "MiB"}, {10, "KiB"}};
  for (const auto& [bits, name] : units) {
    if (value % (std::uint64_t{1} << bits) == 0) return absl::StrCat(value >> bits, " ", name);
  }
  return Grouped(value);
}

TEST(ReadmeTest, ItsTableOfLimitsIsTheServers) {
  using Row = std::pair<std::string, std::string>;
  std::vector<Row> expected;
  for (const LimitEntry& entry : LimitTable()) {
    expected.emplace_back(entry.name, DefaultText(entry));
  }
  std::vector<Row> rows;
  std::ifstream readme(LIMN_README);
  for (std::string line; std::getline(readme, line);) {
    const std::vector<std::string> cells = absl::StrSplit(line, " | ");
    absl::string_view name = cells[0];
    if (cells.size() != 3 || !absl::ConsumePrefix(&name, "| `--")) continue;
    rows.emplace_back(absl::StripSuffix(name, "`"), cells[1]);
  }
  EXPECT_EQ(rows, expected);
}

}  // namespace
}  // namespace limn
