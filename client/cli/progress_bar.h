// SPDX-License-Identifier: MIT
// A progress bar in the last line of a terminal.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace limn::cli {

// Draws on stderr, and only when that is a terminal. Not thread-safe.
class ProgressBar {
 public:
  // wanted: false draws nothing at all.
  explicit ProgressBar(bool wanted);
  // Clears the line.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  static constexpr double kUnknown = -1;

  // Shows a stage and how much of it is done, 0 to 1 or kUnknown; `note` follows it. Cheap enough
  // for every message: draws at most 20 times a second, and whenever the stage changes.
  void Show(std::string_view stage, double fraction, std::string_view note = "");
  // Removes the bar, so that something else can be printed.
  void Clear();

 private:
  bool on_;
  bool drawn_ = false;
  std::string stage_;
  std::chrono::steady_clock::time_point last_;
};

// "[#####---------------]  25 % solve, sweep 3", cut off at `width` columns. A fraction above 1 is
// clamped; one below 0 is not known: "collect, 1,000 vertices". NaN is 0.
[[nodiscard]] std::string FormatProgress(std::string_view stage, double fraction,
                                         std::string_view note, int width);

}  // namespace limn::cli
