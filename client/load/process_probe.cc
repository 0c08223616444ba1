// SPDX-License-Identifier: MIT
#include "client/load/process_probe.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <sstream>
#include <string>

#include "absl/strings/str_cat.h"

namespace limn::load {
namespace {

constexpr std::chrono::milliseconds kInterval(100);

}  // namespace

absl::StatusOr<std::unique_ptr<ProcessProbe>> ProcessProbe::Start(int pid) {
  std::unique_ptr<ProcessProbe> probe(new ProcessProbe(pid));
  if (!probe->LookNow(&probe->first_)) {
    return absl::NotFoundError(absl::StrCat("there is no process ", pid, " to look at"));
  }
  probe->use_.bytes_before = probe->first_.bytes;
  probe->use_.bytes_peak = probe->first_.bytes;
  probe->thread_ = std::thread([&probe = *probe] { probe.Watch(); });
  return probe;
}

ProcessProbe::~ProcessProbe() { (void)Stop(); }

ProcessUse ProcessProbe::Stop() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
  Look last;
  if (LookNow(&last)) {
    use_.bytes_after = last.bytes;
    use_.cpu_seconds = last.cpu_seconds - first_.cpu_seconds;
  }
  return use_;
}

// Fields 14, 15 (times in ticks) and 24 (pages) of stat; the second one, a name in parentheses, may
// have spaces.
bool ProcessProbe::LookNow(Look* look) const {
  std::ifstream file(absl::StrCat("/proc/", pid_, "/stat"));
  std::string text;
  if (!std::getline(file, text) || text.rfind(')') == std::string::npos) return false;
  std::istringstream fields(text.substr(text.rfind(')') + 1));
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user = 0;
  double system = 0;
  fields >> user >> system;
  for (int field = 16; field < 24; ++field) fields >> skipped;
  std::uint64_t pages = 0;
  fields >> pages;
  if (!fields) return false;
  look->cpu_seconds = (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  look->bytes = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return true;
}

void ProcessProbe::Watch() {
  std::unique_lock lock(mutex_);
  while (!changed_.wait_for(lock, kInterval, [this] { return ending_; })) {
    Look look;
    if (!LookNow(&look)) continue;
    use_.bytes_peak = std::max(use_.bytes_peak, look.bytes);
    use_.cpu_seconds = look.cpu_seconds - first_.cpu_seconds;
  }
}

}  // namespace limn::load
