// SPDX-License-Identifier: MIT
// A report in Markdown that also keeps what was promised and whether it held.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace limn::experiments {

class Report {
 public:
  using Row = std::vector<std::string>;

  void Title(std::string_view text);
  void Heading(std::string_view text);
  void Paragraph(std::string_view text);
  // All rows as long as the header.
  void Table(const Row& header, const std::vector<Row>& rows);
  // Pictures side by side over their captions. Files are relative to the report's folder.
  struct Picture {
    std::string file;
    std::string caption;
  };
  void Pictures(const std::vector<Picture>& pictures);

  // Notes that value has to be at most bound. NaN is above every bound.
  void CheckAtMost(std::string_view what, double value, double bound);
  // Notes that something has to be so.
  void Check(std::string_view what, bool holds);

  // Whether all checks held so far.
  bool all_held() const { return failures_.empty(); }
  const std::vector<std::string>& failures() const { return failures_; }
  // Everything so far, and at the end the checks.
  std::string Markdown() const;

 private:
  void AddCheck(std::string_view what, const std::string& found, bool holds);

  std::string text_;
  std::vector<Row> checks_;
  std::vector<std::string> failures_;
};

// The cells of a table.
std::string Count(std::size_t value);           // 11,540
std::string Milliseconds(double milliseconds);  // three digits
std::string Scientific(double value);           // 1.2e-13

}  // namespace limn::experiments
