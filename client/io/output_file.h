// SPDX-License-Identifier: MIT
// A file that appears under its name only when it is complete.
#pragma once

#include <charconv>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "engine/base/buffer.h"

namespace limn::io {

// Writes go to a buffer and from there to a file beside the target, of a name that nobody else has.
// The first error sticks and is what Commit returns. Not thread-safe.
class OutputFile {
 public:
  // stop: looked at with every buffer that is written; once it says true the file fails with
  // CANCELLED. Errors: as CheckWritable, apart from the extension.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<OutputFile>> Create(
      const std::string& path, std::function<bool()> stop = {});
  // Removes what was not put in its place, and what was kept of an older file.
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void Append(std::string_view bytes);
  // A number as the shortest decimals that read back to the same value.
  template <class Number>
  void AppendNumber(Number number) {
    constexpr std::size_t kLongest = 32;
    if (buffer_.size() - used_ < kLongest) Flush();
    char* begin = buffer_.data() + used_;
    used_ += static_cast<std::size_t>(std::to_chars(begin, begin + kLongest, number).ptr - begin);
  }
  // The bytes of a plain value, as they are in memory.
  template <class Value>
  void AppendRaw(const Value& value) {
    Append({reinterpret_cast<const char*>(&value), sizeof value});
  }

  // Whether nothing failed so far; lets long loops stop early.
  bool ok() const { return status_.ok(); }
  // Puts the file in its place: Close and Place.
  [[nodiscard]] absl::Status Commit();

  // The two steps of Commit, for files that are to appear together. After Place the older file, if
  // there was one, is kept until the destructor; Undo puts it back.
  [[nodiscard]] absl::Status Close();
  [[nodiscard]] absl::Status Place();
  void Undo();

 private:
  OutputFile(std::string target, std::string partial, int descriptor);
  [[nodiscard]] absl::Status KeepOlder();
  void Flush();
  void Write(std::string_view bytes);

  std::string target_;
  std::string partial_;
  // Another name of the older file while it can still be put back.
  std::string older_;
  bool placed_ = false;
  std::function<bool()> stop_;
  int descriptor_;
  absl::Status status_;
  Buffer<char> buffer_;
  std::size_t used_ = 0;
};

}  // namespace limn::io
