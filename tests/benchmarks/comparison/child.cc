// SPDX-License-Identifier: MIT
// Children, their memory, and the clock.
#include <malloc.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <stdexcept>

#include "tests/benchmarks/comparison/measure.h"

namespace limn::comparison {
namespace {

// A line of /proc/self/status, such as "VmHWM", in bytes.
double StatusBytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != key + ":") continue;
    double kilobytes = 0;
    status >> kilobytes;
    return 1024 * kilobytes;
  }
  return 0;
}

}  // namespace

std::string InChild(const std::function<void(std::FILE* out)>& work) {
  int ends[2];
  std::fflush(nullptr);
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child");
  if (child == 0) {
    close(ends[0]);
    std::FILE* const out = fdopen(ends[1], "w");
    setvbuf(out, nullptr, _IOLBF, BUFSIZ);
    int status = 0;
    try {
      work(out);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "compare: %s\n", error.what());
      status = 1;
    }
    std::fflush(out);
    // Not exit: nothing of the parent's is to be ended here.
    _exit(status);
  }
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t got = 0; (got = read(ends[0], buffer, sizeof(buffer))) > 0;) {
    text.append(buffer, static_cast<std::size_t>(got));
  }
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) text += "\ncrashed\n";
  return text;
}

double PeakBytes(const std::function<void()>& work) {
  malloc_trim(0);
  // Sets the peak back to what is resident now.
  std::ofstream("/proc/self/clear_refs") << "5\n";
  const double before = StatusBytes("VmRSS");
  work();
  return std::max(0.0, StatusBytes("VmHWM") - before);
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

Instant Now() {
  timespec processor = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &processor);
  const auto clock = std::chrono::steady_clock::now().time_since_epoch();
  return {std::chrono::duration<double>(clock).count(),
          static_cast<double>(processor.tv_sec) + 1e-9 * static_cast<double>(processor.tv_nsec)};
}

}  // namespace limn::comparison
