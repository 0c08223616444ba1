// SPDX-License-Identifier: MIT
// Splits a text file into tokens and lines and parses numbers, without locale and allocation.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>

#include "absl/strings/escaping.h"
#include "absl/strings/string_view.h"

namespace limn::io {

class TextScanner {
 public:
  // comment: the character that starts a comment up to the end of the line, or '\0'.
  // continued: whether a backslash at the end of a line joins the next line to it. A byte order
  // mark of UTF-8 at the beginning is no part of the text.
  TextScanner(std::string_view text, char comment, bool continued)
      : text_(text), comment_(comment), continued_(continued) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) at_ = kByteOrderMark.size();
  }

  // The next token of this line; empty at its end.
  std::string_view TokenOnLine() {
    SkipBlanks();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !IsBlank(text_[at_]) && !IsLineEnd(text_[at_]) &&
           !IsComment(text_[at_]) && !AtJoin()) {
      ++at_;
    }
    return text_.substr(begin, at_ - begin);
  }

  // The next token, on whichever line; empty at the end of the file.
  std::string_view Token() {
    while (true) {
      const std::string_view token = TokenOnLine();
      if (!token.empty() || !NextLine()) return token;
    }
  }

  // Goes to the beginning of the next line; false at the end of the file.
  bool NextLine() {
    while (at_ < text_.size() && !IsLineEnd(text_[at_])) {
      if (!Join()) ++at_;
    }
    if (at_ == text_.size()) return false;
    SkipLineEnd();
    return true;
  }

  // Number of the present line, from 1.
  std::uint64_t line() const { return line_; }
  // Bytes before and after the scanner.
  std::size_t offset() const { return at_; }
  std::size_t left() const { return text_.size() - at_; }

 private:
  static bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
  static bool IsLineEnd(char c) { return c == '\n' || c == '\r'; }
  bool IsComment(char c) const { return comment_ != '\0' && c == comment_; }
  bool AtJoin() const {
    return continued_ && text_[at_] == '\\' && at_ + 1 < text_.size() && IsLineEnd(text_[at_ + 1]);
  }
  bool Join() {
    if (!AtJoin()) return false;
    ++at_;
    SkipLineEnd();
    return true;
  }
  void SkipLineEnd() {
    const bool pair = text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n';
    at_ += pair ? 2 : 1;
    ++line_;
  }
  void SkipBlanks() {
    while (at_ < text_.size() && (IsBlank(text_[at_]) || Join())) {
      if (at_ < text_.size() && IsBlank(text_[at_])) ++at_;
    }
    if (at_ < text_.size() && IsComment(text_[at_])) {
      while (at_ < text_.size() && !IsLineEnd(text_[at_])) ++at_;
    }
  }

  std::string_view text_;
  char comment_;
  bool continued_;
  std::size_t at_ = 0;
  std::uint64_t line_ = 1;
};

// The double nearest to a decimal; "inf" and "nan" are numbers, and what is too large for a double
// is infinite. False if the token is anything else.
inline bool ParseDouble(std::string_view token, double* value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  if (token.empty() || token.front() == '+') return false;
  const char* end = token.data() + token.size();
  const std::from_chars_result result = std::from_chars(token.data(), end, *value);
  if (result.ptr != end) return false;
  if (result.ec == std::errc::result_out_of_range) {
    // Not said whether too large or too small; strtod tells.
    *value = std::strtod(std::string(token).c_str(), nullptr);
    return true;
  }
  return result.ec == std::errc();
}

// A decimal integer of 64 bits. False if the token is anything else.
inline bool ParseInteger(std::string_view token, std::int64_t* value) {
  if (!token.empty() && token.front() == '+') token.remove_prefix(1);
  if (token.empty() || token.front() == '+') return false;
  const char* end = token.data() + token.size();
  const std::from_chars_result result = std::from_chars(token.data(), end, *value);
  return result.ptr == end && result.ec == std::errc();
}

// A token for a message: printable, quoted, and short.
inline std::string Quoted(std::string_view token) {
  constexpr std::size_t kLongest = 40;
  if (token.empty()) return "the end of the line";
  const std::string_view start = token.substr(0, kLongest);
  return "\"" + absl::CHexEscape(absl::string_view(start.data(), start.size())) +
         (token.size() > kLongest ? "...\"" : "\"");
}

}  // namespace limn::io
