// SPDX-License-Identifier: MIT
#include "tests/experiments/report.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace limn::experiments {
namespace {

std::string Line(const Report::Row& cells) {
  return absl::StrCat("| ", absl::StrJoin(cells, " | "), " |\n");
}

bool IsNumber(const std::string& cell) { return !cell.empty() && cell[0] >= '0' && cell[0] <= '9'; }

// Columns of numbers are set to the right.
std::string TableText(const Report::Row& header, const std::vector<Report::Row>& rows) {
  Report::Row rule;
  for (std::size_t column = 0; column < header.size(); ++column) {
    const bool numbers = std::all_of(rows.begin(), rows.end(),
                                     [&](const Report::Row& row) { return IsNumber(row[column]); });
    rule.emplace_back(numbers ? "---:" : "---");
  }
  std::string text = Line(header) + Line(rule);
  for (const Report::Row& row : rows) text += Line(row);
  return text + "\n";
}

}  // namespace

void Report::Title(std::string_view text) {
  absl::StrAppend(&text_, "# ", std::string(text), "\n\n");
}

void Report::Heading(std::string_view text) {
  absl::StrAppend(&text_, "## ", std::string(text), "\n\n");
}

void Report::Paragraph(std::string_view text) {
  absl::StrAppend(&text_, std::string(text), "\n\n");
}

void Report::Table(const Row& header, const std::vector<Row>& rows) {
  text_ += TableText(header, rows);
}

void Report::Pictures(const std::vector<Picture>& pictures) {
  Row images;
  Row captions;
  for (const Picture& picture : pictures) {
    images.push_back(absl::StrCat("![", picture.caption, "](", picture.file, ")"));
    captions.push_back(picture.caption);
  }
  const Row rule(pictures.size(), ":---:");
  text_ += Line(images) + Line(rule) + Line(captions) + "\n";
}

void Report::CheckAtMost(std::string_view what, double value, double bound) {
  AddCheck(what, absl::StrFormat("%.2g, at most %.3g", value, bound), value <= bound);
}

void Report::Check(std::string_view what, bool holds) {
  AddCheck(what, holds ? "yes" : "no", holds);
}

void Report::AddCheck(std::string_view what, const std::string& found, bool holds) {
  checks_.push_back({std::string(what), found, holds ? "held" : "FAILED"});
  if (!holds) failures_.push_back(absl::StrCat(std::string(what), ": ", found));
}

std::string Report::Markdown() const {
  if (checks_.empty()) return text_;
  return absl::StrCat(text_, "## Checks\n\nThe run fails if one of these does.\n\n",
                      TableText({"what", "found", ""}, checks_));
}

std::string Count(std::size_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ',');
  return digits;
}

std::string Milliseconds(double milliseconds) {
  const int decimals = milliseconds < 1 ? 3 : milliseconds < 10 ? 2 : milliseconds < 100 ? 1 : 0;
  return absl::StrFormat("%.*f", decimals, milliseconds);
}

std::string Scientific(double value) { return absl::StrFormat("%.1e", value); }

}  // namespace limn::experiments
