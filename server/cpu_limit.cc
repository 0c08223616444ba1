// SPDX-License-Identifier: MIT
#include "server/cpu_limit.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <thread>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace limn {
namespace {

std::optional<std::string> ReadFile(const std::string& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::optional<double> Ratio(const std::string& quota, const std::string& period) {
  double q = 0;
  double p = 0;
  // "max" and -1 mean no quota.
  if (!absl::SimpleAtod(quota, &q) || !absl::SimpleAtod(period, &p)) return std::nullopt;
  if (!(q > 0) || !(p > 0)) return std::nullopt;
  return q / p;
}

std::optional<double> QuotaV2(const std::string& directory) {
  const std::optional<std::string> text = ReadFile(absl::StrCat(directory, "/cpu.max"));
  if (!text.has_value()) return std::nullopt;
  const std::vector<std::string> parts =
      absl::StrSplit(*text, absl::ByAnyChar(" \n"), absl::SkipEmpty());
  if (parts.size() != 2) return std::nullopt;
  return Ratio(parts[0], parts[1]);
}

std::optional<double> QuotaV1(const std::string& directory) {
  const auto quota = ReadFile(absl::StrCat(directory, "/cpu.cfs_quota_us"));
  const auto period = ReadFile(absl::StrCat(directory, "/cpu.cfs_period_us"));
  if (!quota.has_value() || !period.has_value()) return std::nullopt;
  return Ratio(*quota, *period);
}

std::optional<double> Smaller(std::optional<double> a, std::optional<double> b) {
  if (!a.has_value()) return b;
  if (!b.has_value()) return a;
  return std::min(*a, *b);
}

// The smallest quota on the way from the group up to the mount. In a container the path of the
// membership may not exist under the mount; the mount itself is then the group.
template <class Quota>
std::optional<double> SmallestOnPath(const std::string& mount, std::string path,
                                     const Quota& quota) {
  std::optional<double> smallest = quota(mount);
  while (path.size() > 1) {
    smallest = Smaller(smallest, quota(absl::StrCat(mount, path)));
    path.resize(path.rfind('/'));
  }
  return smallest;
}

bool HasCpuController(const std::string& controllers) {
  for (absl::string_view controller : absl::StrSplit(controllers, ',')) {
    if (controller == "cpu") return true;
  }
  return false;
}

int AffinityCount() {
  // The mask may be longer than cpu_set_t on large machines; the call fails until it fits.
  for (int processors = CPU_SETSIZE; processors <= 1 << 20; processors *= 2) {
    cpu_set_t* set = CPU_ALLOC(processors);
    const std::size_t size = CPU_ALLOC_SIZE(processors);
    const bool ok = sched_getaffinity(0, size, set) == 0;
    const int count = ok ? CPU_COUNT_S(size, set) : 0;
    CPU_FREE(set);
    if (ok) return count;
  }
  return static_cast<int>(std::thread::hardware_concurrency());
}

}  // namespace

std::optional<double> CgroupCpuQuota(const std::string& membership, const std::string& mount) {
  std::optional<double> smallest;
  for (absl::string_view line : absl::StrSplit(membership, '\n', absl::SkipEmpty())) {
    // hierarchy:controllers:path
    const std::vector<std::string> parts = absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (parts.size() != 3 || parts[2].empty() || parts[2][0] != '/') continue;
    const std::string& path = parts[2];
    if (parts[1].empty()) {
      smallest = Smaller(smallest, SmallestOnPath(mount, path, QuotaV2));
    } else if (HasCpuController(parts[1])) {
      for (const std::string& directory :
           {absl::StrCat(mount, "/cpu"), absl::StrCat(mount, "/", parts[1])}) {
        smallest = Smaller(smallest, SmallestOnPath(directory, path, QuotaV1));
      }
    }
  }
  return smallest;
}

int CpuLimit() {
  int limit = std::max(1, AffinityCount());
  const std::optional<std::string> membership = ReadFile("/proc/self/cgroup");
  if (!membership.has_value()) return limit;
  const std::optional<double> quota = CgroupCpuQuota(*membership, "/sys/fs/cgroup");
  if (quota.has_value() && *quota < limit) limit = static_cast<int>(std::ceil(*quota));
  return std::max(1, limit);
}

}  // namespace limn
