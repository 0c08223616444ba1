// SPDX-License-Identifier: MIT
// A progress bar in the last line of a terminal.
#include "client/cli/progress_bar.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>

#include "absl/strings/str_format.h"

namespace limn::cli {
namespace {

constexpr int kBarCells = 24;
constexpr int kDefaultWidth = 80;
constexpr std::chrono::milliseconds kInterval{50};

int TerminalWidth() {
  winsize size = {};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kDefaultWidth;
  return size.ws_col;
}

}  // namespace

std::string FormatProgress(std::string_view stage, double fraction, std::string_view note,
                           int width) {
  // The comparison is false for NaN, which counts as nothing done.
  const double done = fraction > 0 ? std::min(fraction, 1.0) : 0.0;
  const auto cells = static_cast<std::size_t>(done * kBarCells);
  std::string line = fraction < 0 ? std::string(stage)
                                  : absl::StrFormat("[%s%s] %3d %% %s", std::string(cells, '#'),
                                                    std::string(kBarCells - cells, '-'),
                                                    static_cast<int>(done * 100), stage);
  if (!note.empty()) line.append(", ").append(note);
  // One column stays free: a full line makes some terminals wrap.
  line.resize(std::min(line.size(), static_cast<std::size_t>(std::max(width - 1, 1))));
  return line;
}

ProgressBar::ProgressBar(bool wanted) : on_(wanted && isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() { Clear(); }

void ProgressBar::Show(std::string_view stage, double fraction, std::string_view note) {
  if (!on_) return;
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && stage == stage_ && now - last_ < kInterval) return;
  stage_ = std::string(stage);
  last_ = now;
  drawn_ = true;
  const std::string line = FormatProgress(stage, fraction, note, TerminalWidth());
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
  std::fflush(stderr);
}

void ProgressBar::Clear() {
  if (!drawn_) return;
  drawn_ = false;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
}

}  // namespace limn::cli
