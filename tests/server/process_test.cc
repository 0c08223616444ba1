// SPDX-License-Identifier: MIT
// What the server finds out about, and tells, its surroundings: CPU quota, addresses, logs, limits.
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "engine/base/error.h"
#include "server/limits.h"
#include "server/listen_address.h"
#include "server/log.h"
#include "server/machine_limits.h"

namespace limn {
namespace {

// A directory of control groups made by the test.
class CgroupTest : public testing::Test {
 protected:
  void SetUp() override {
    mount_ = std::filesystem::temp_directory_path() /
             ("limn_cgroup_" + std::to_string(::getpid()) + "_" +
              testing::UnitTest::GetInstance()->current_test_info()->name());
  }
  void TearDown() override { std::filesystem::remove_all(mount_); }

  void Put(const std::string& path, const std::string& text) {
    const std::filesystem::path file = mount_ / path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  std::optional<double> Quota(const std::string& membership) {
    return CgroupCpuQuota(membership, mount_.string());
  }

  std::filesystem::path mount_;
};

TEST_F(CgroupTest, Version2TakesTheSmallestQuotaOnThePath) {
  Put("cpu.max", "max 100000\n");
  Put("a/cpu.max", "150000 100000\n");
  Put("a/b/cpu.max", "400000 100000\n");
  EXPECT_EQ(Quota("0::/a/b\n"), 1.5);
}

TEST_F(CgroupTest, Version1IsRead) {
  Put("cpu/jobs/cpu.cfs_quota_us", "50000\n");
  Put("cpu/jobs/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(Quota("12:memory:/jobs\n4:cpu:/jobs\n"), 0.5);
}

TEST_F(CgroupTest, Version1OfAContainerIsFoundAtTheMount) {
  Put("cpu,cpuacct/cpu.cfs_quota_us", "300000\n");
  Put("cpu,cpuacct/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(Quota("4:cpu,cpuacct:/not/here\n"), 3.0);
}

TEST_F(CgroupTest, NoQuotaAndNonsenseAreNoLimit) {
  Put("cpu.max", "max 100000\n");
  Put("cpu/cpu.cfs_quota_us", "-1\n");
  Put("cpu/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(Quota("0::/\n4:cpu:/\n"), std::nullopt);
  Put("cpu.max", "what\n");
  EXPECT_EQ(Quota("0::/\n"), std::nullopt);
  EXPECT_EQ(Quota("nonsense"), std::nullopt);
  EXPECT_EQ(Quota(""), std::nullopt);
}

TEST_F(CgroupTest, MemoryLimitsOfBothVersionsAreRead) {
  Put("memory.max", "max\n");
  Put("a/memory.max", "1073741824\n");
  Put("memory/jobs/memory.limit_in_bytes", "536870912\n");
  const auto limit = [&](const std::string& membership) {
    return CgroupMemoryLimit(membership, mount_.string());
  };
  EXPECT_EQ(limit("0::/a\n"), 1073741824.0);
  EXPECT_EQ(limit("0::/a\n9:memory:/jobs\n"), 536870912.0);
  EXPECT_EQ(limit("0::/\n"), std::nullopt);
  EXPECT_GT(MemoryLimit(), 1U << 20);
}

TEST(CpuLimitTest, IsAtLeastOne) { EXPECT_GE(CpuLimit(), 1); }

TEST(ListenAddressTest, LoopbackIsTakenAndTheRestOnlyWhenTold) {
  for (const char* address : {"127.0.0.1:0", "127.8.9.1:7410", "localhost:65535", "[::1]:1"}) {
    EXPECT_TRUE(CheckListenAddress(address, false).ok()) << address;
  }
  for (const char* address : {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "example.org:1", "128.0.0.1:1",
                              "127.0.0.1.example.org:1"}) {
    EXPECT_FALSE(CheckListenAddress(address, false).ok()) << address;
    EXPECT_TRUE(CheckListenAddress(address, true).ok()) << address;
  }
  for (const char* address : {"", ":", ":1", "localhost", "localhost:", "localhost:x",
                              "127.0.0.1:65536", "127.0.0.1:-1", "::1:1", "unix:/tmp/x"}) {
    EXPECT_EQ(GetErrorDetail(CheckListenAddress(address, true))->field, "listen") << address;
  }
}

TEST(LogTest, OneEventIsOneLineWhateverIsInIt) {
  LogLine line("job");
  line.Add("request_id", "abc-1.2").Add("message", "two\nlines \"quoted\" x=1").Add("empty", "");
  line.Add("ms", 1.23456).Add("count", std::uint64_t{7});
  EXPECT_EQ(line.text(),
            "event=job request_id=abc-1.2 message=\"two\\nlines \\\"quoted\\\" x=1\" empty=\"\" "
            "ms=1.235 count=7");
}

TEST(LogTest, LevelsAreCheckedByName) {
  EXPECT_TRUE(Log::ToStderr("warning").ok());
  EXPECT_TRUE(Log::ToStderr("off").ok());
  EXPECT_EQ(GetErrorDetail(Log::ToStderr("loud").status())->field, "log-level");
}

TEST(LimitsTest, TheTableIsCompleteAndItsDefaultsAreInRange) {
  std::set<std::string_view> names;
  for (const LimitEntry& entry : LimitTable()) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_GE(ServerLimits{}.*entry.value, entry.least) << entry.name;
    EXPECT_LE(ServerLimits{}.*entry.value, entry.most) << entry.name;
    EXPECT_FALSE(entry.unit.empty());
    EXPECT_FALSE(entry.description.empty());
  }
  EXPECT_EQ(names.size() * sizeof(std::uint64_t), sizeof(ServerLimits));
}

}  // namespace
}  // namespace limn
