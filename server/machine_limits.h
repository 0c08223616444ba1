// SPDX-License-Identifier: MIT
// How many processors and how much memory this process may really use. oneTBB looks at the affinity
// mask only, so that in a container with a CPU quota it would start too many threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace limn {

// min(processors in the affinity mask, CPU quota of the control group rounded up), at least 1.
[[nodiscard]] int CpuLimit();

// The quota of the control groups named in `membership` (the text of /proc/self/cgroup) and of
// their ancestors, in processors; version 2 (cpu.max) and version 1 (cpu.cfs_quota_us) under
// `mount` ("/sys/fs/cgroup"). Nothing when there is no quota or nothing is readable.
[[nodiscard]] std::optional<double> CgroupCpuQuota(const std::string& membership,
                                                   const std::string& mount);

// min(memory of the machine, limit of the control group), in bytes.
[[nodiscard]] std::uint64_t MemoryLimit();

// As CgroupCpuQuota, for memory in bytes: memory.max and memory.limit_in_bytes.
[[nodiscard]] std::optional<double> CgroupMemoryLimit(const std::string& membership,
                                                      const std::string& mount);

// Bytes of memory that the process occupies now. Thread-safe.
[[nodiscard]] std::uint64_t ResidentBytes();

}  // namespace limn
