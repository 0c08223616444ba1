// SPDX-License-Identifier: MIT
// Structured logs: one line per event, key=value, to standard error.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace limn {

// The text of an event: `event=NAME key=value ...`. Values that hold anything but letters, digits
// and a few harmless signs are quoted, with control characters escaped: one event is one line,
// whatever a client sends.
class LogLine {
 public:
  explicit LogLine(std::string_view event);
  LogLine& Add(std::string_view key, std::string_view value);
  LogLine& Add(std::string_view key, const char* value) {
    return Add(key, std::string_view(value));
  }
  LogLine& Add(std::string_view key, std::uint64_t value);
  // With three decimals.
  LogLine& Add(std::string_view key, double value);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// Where events go. Thread-safe. Writing never blocks: lines wait in a bounded queue, and when the
// reader of standard error stands still the oldest are dropped.
class Log {
 public:
  // level: "debug", "info", "warning", "error" or "off". Errors: INVALID_OPTION.
  static absl::StatusOr<std::shared_ptr<Log>> ToStderr(std::string_view level);
  // Calls the function with the text of every event, from any thread, several at a time. It must
  // not block.
  static std::shared_ptr<Log> ToFunction(std::function<void(std::string_view)> function);
  // Drops everything, for embedded use.
  static std::shared_ptr<Log> Null();
  // Writes what waits, for two seconds at the most.
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void Debug(const LogLine& line);
  void Info(const LogLine& line);
  void Warning(const LogLine& line);
  void Error(const LogLine& line);

  // Waits until what has been logged is written. False: it was not within the time.
  bool Flush(std::chrono::milliseconds patience);

 private:
  struct Impl;
  void Write(int level, const LogLine& line);
  explicit Log(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace limn
