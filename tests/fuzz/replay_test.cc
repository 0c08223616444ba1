// SPDX-License-Identifier: MIT
// The fuzz targets on their seeds, on every truncation of them and on damaged ones: the small
// bounded run that every build has.
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <string>

#include "tests/engine/allocation_meter.h"
#include "tests/fuzz/targets.h"
#include "tests/oracle/slowdown.h"

namespace limn::fuzz {
namespace {

using Clock = std::chrono::steady_clock;

class ReplayTest : public testing::TestWithParam<Target> {
 protected:
  // Whatever it is: done within 50 ms and 64 MiB (and what the target itself may hold).
  static bool Run(const std::string& bytes) {
    const AllocationMeter meter;
    const Clock::time_point start = Clock::now();
    const bool sound = GetParam().run(bytes);
    slowest_ = std::max(slowest_, Clock::now() - start);
    EXPECT_LT(meter.peak(), std::size_t{128} << 20);
    return sound;
  }
  static inline Clock::duration slowest_{0};
};

TEST_P(ReplayTest, SeedsAndTheirTruncations) {
  slowest_ = Clock::duration(0);
  int sound = 0;
  for (const std::string& seed : GetParam().seeds()) {
    sound += Run(seed) ? 1 : 0;
    for (std::size_t size = 0; size < seed.size(); size += 1 + seed.size() / 100) {
      Run(seed.substr(0, size));
    }
  }
  // They reach what is behind the first checks.
  EXPECT_GE(sound, 4);
  EXPECT_LT(slowest_, std::chrono::milliseconds(500) * oracle::kSlowdown);
}

TEST_P(ReplayTest, DamagedSeeds) {
  const unsigned seed_of_all = 4711;
  SCOPED_TRACE(seed_of_all);
  std::mt19937 random(seed_of_all);
  const std::vector<std::string> seeds = GetParam().seeds();
  for (int round = 0; round < 2000 / oracle::kSlowdown; ++round) {
    std::string bytes = seeds[random() % seeds.size()];
    for (unsigned changes = 1 + random() % 4; changes > 0 && !bytes.empty(); --changes) {
      const std::size_t at = random() % bytes.size();
      switch (random() % 4) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
          break;
        case 2:
          bytes.erase(at, 1 + random() % 8);
          break;
        default:
          bytes.insert(at, 1 + random() % 8, static_cast<char>(random()));
          break;
      }
    }
    Run(bytes);
  }
}

TEST_P(ReplayTest, Noise) {
  std::mt19937 random(1);
  for (int round = 0; round < 300; ++round) {
    std::string bytes(random() % 300, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    Run(bytes);
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, ReplayTest, testing::ValuesIn(Targets()),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace limn::fuzz
