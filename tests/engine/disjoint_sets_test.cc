// SPDX-License-Identifier: MIT
#include "engine/base/disjoint_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace limn {
namespace {

TEST(DisjointSets, EveryNumberStartsInASetOfItsOwn) {
  DisjointSets sets(5);
  for (std::uint32_t i = 0; i < 5; ++i) EXPECT_EQ(sets.Find(i), i);
}

// Against a list of names that is gone through for every merge.
TEST(DisjointSets, TheSmallestNumberIsTheNameWhateverTheOrder) {
  constexpr std::uint64_t kSeed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 200; ++round) {
    const auto size = static_cast<std::uint32_t>(1 + random() % 40);
    DisjointSets sets(size);
    std::vector<std::uint32_t> name(size);
    for (std::uint32_t i = 0; i < size; ++i) name[i] = i;
    for (auto merges = random() % 50; merges > 0; --merges) {
      const auto a = static_cast<std::uint32_t>(random() % size);
      const auto b = static_cast<std::uint32_t>(random() % size);
      sets.Merge(a, b);
      const std::uint32_t low = std::min(name[a], name[b]);
      const std::uint32_t high = std::max(name[a], name[b]);
      for (std::uint32_t& n : name) {
        if (n == high) n = low;
      }
      if (random() % 4 == 0) {
        EXPECT_EQ(sets.Find(a), name[a]);
      }
    }
    for (std::uint32_t i = 0; i < size; ++i) ASSERT_EQ(sets.Find(i), name[i]);
  }
}

}  // namespace
}  // namespace limn
