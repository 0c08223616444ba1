// SPDX-License-Identifier: MIT
#include "server/machine_limits.h"

#include <sched.h>
#include <unistd.h>

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

std::optional<double> BytesIn(const std::string& file) {
  const std::optional<std::string> text = ReadFile(file);
  double bytes = 0;
  // "max" is no number; version 1 says no limit by a number beyond all memory.
  if (!text.has_value() || !absl::SimpleAtod(*text, &bytes) || !(bytes > 0)) return std::nullopt;
  return bytes;
}

std::optional<double> MemoryV2(const std::string& directory) {
  return BytesIn(absl::StrCat(directory, "/memory.max"));
}

std::optional<double> MemoryV1(const std::string& directory) {
  return BytesIn(absl::StrCat(directory, "/memory.limit_in_bytes"));
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

bool HasController(const std::string& controllers, absl::string_view wanted) {
  for (absl::string_view controller : absl::StrSplit(controllers, ',')) {
    if (controller == wanted) return true;
  }
  return false;
}

using Reader = std::optional<double> (*)(const std::string& directory);

// What limits a control group of either version.
struct Limiter {
  absl::string_view controller;
  Reader v1;
  Reader v2;
};

std::optional<double> SmallestLimit(const std::string& membership, const std::string& mount,
                                    const Limiter& limiter) {
  std::optional<double> smallest;
  for (absl::string_view line : absl::StrSplit(membership, '\n', absl::SkipEmpty())) {
    // hierarchy:controllers:path
    const std::vector<std::string> parts = absl::StrSplit(line, absl::MaxSplits(':', 2));
    if (parts.size() != 3 || parts[2].empty() || parts[2][0] != '/') continue;
    const std::string& path = parts[2];
    if (parts[1].empty()) {
      smallest = Smaller(smallest, SmallestOnPath(mount, path, limiter.v2));
    } else if (HasController(parts[1], limiter.controller)) {
      for (const std::string& directory :
           {absl::StrCat(mount, "/", limiter.controller), absl::StrCat(mount, "/", parts[1])}) {
        smallest = Smaller(smallest, SmallestOnPath(directory, path, limiter.v1));
      }
    }
  }
  return smallest;
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
  return SmallestLimit(membership, mount, {.controller = "cpu", .v1 = QuotaV1, .v2 = QuotaV2});
}

std::optional<double> CgroupMemoryLimit(const std::string& membership, const std::string& mount) {
  return SmallestLimit(membership, mount, {.controller = "memory", .v1 = MemoryV1, .v2 = MemoryV2});
}

int CpuLimit() {
  int limit = std::max(1, AffinityCount());
  const std::optional<std::string> membership = ReadFile("/proc/self/cgroup");
  if (!membership.has_value()) return limit;
  const std::optional<double> quota = CgroupCpuQuota(*membership, "/sys/fs/cgroup");
  if (quota.has_value() && *quota < limit) limit = static_cast<int>(std::ceil(*quota));
  return std::max(1, limit);
}

std::uint64_t MemoryLimit() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  double bytes = pages > 0 && page_bytes > 0
                     ? static_cast<double>(pages) * static_cast<double>(page_bytes)
                     : 1e18;
  const std::optional<std::string> membership = ReadFile("/proc/self/cgroup");
  if (membership.has_value()) {
    const std::optional<double> limit = CgroupMemoryLimit(*membership, "/sys/fs/cgroup");
    if (limit.has_value()) bytes = std::min(bytes, *limit);
  }
  return static_cast<std::uint64_t>(bytes);
}

std::uint64_t ResidentBytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t total = 0;
  std::uint64_t resident = 0;
  file >> total >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace limn
