// SPDX-License-Identifier: MIT
// Shares of clients whose jobs wait.
#include "server/fair_queue.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>
#include <vector>

namespace limn {
namespace {

using Clock = FairQueue::Clock;
constexpr Clock::time_point kStart{};
constexpr auto kPatience = std::chrono::seconds(100);

std::vector<FairQueue::Id> PopAll(FairQueue* queue, Clock::time_point now = kStart) {
  std::vector<FairQueue::Id> order;
  while (const std::optional<FairQueue::Id> next = queue->Pop(now)) order.push_back(*next);
  return order;
}

TEST(FairQueueTest, OneClientsJobsKeepTheirOrder) {
  FairQueue queue(kPatience);
  for (FairQueue::Id id = 1; id <= 5; ++id) queue.Push(id, "a", 100 / id, kStart);
  EXPECT_EQ(PopAll(&queue), (std::vector<FairQueue::Id>{1, 2, 3, 4, 5}));
  EXPECT_TRUE(queue.empty());
  EXPECT_FALSE(queue.Pop(kStart).has_value());
}

TEST(FairQueueTest, AClientWithManyJobsDoesNotHoldUpOneWithFew) {
  FairQueue queue(kPatience);
  for (FairQueue::Id id = 1; id <= 100; ++id) queue.Push(id, "many", 10, kStart);
  queue.Push(101, "few", 10, kStart);
  queue.Push(102, "few", 10, kStart);
  std::vector<FairQueue::Id> first;
  for (int i = 0; i < 4; ++i) first.push_back(*queue.Pop(kStart));
  EXPECT_EQ(first, (std::vector<FairQueue::Id>{1, 101, 2, 102}));
}

TEST(FairQueueTest, ClientsGetTheSameShareOfWorkWhateverTheSizeOfTheirJobs) {
  FairQueue queue(kPatience);
  std::map<FairQueue::Id, std::pair<std::string, double>> jobs;
  const unsigned seed = 7;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  FairQueue::Id id = 0;
  const auto push = [&](const std::string& client, std::uint64_t cost) {
    queue.Push(++id, client, cost, kStart);
    jobs[id] = {client, static_cast<double>(cost)};
  };
  for (int i = 0; i < 3000; ++i) push("small", 1 + random() % 10);
  for (int i = 0; i < 300; ++i) push("medium", 20 + random() % 60);
  for (int i = 0; i < 30; ++i) push("large", 400 + random() % 200);
  std::map<std::string, double> done;
  // As long as all of them have jobs left.
  double total = 0;
  while (total < 30'000) {
    const auto& [client, cost] = jobs.at(*queue.Pop(kStart));
    done[client] += cost;
    total += cost;
  }
  // Within the largest job of each other.
  for (const auto& [client, work] : done) EXPECT_NEAR(work, total / 3, 600) << client;
}

TEST(FairQueueTest, WhoWasAwayHasSavedNothingUp) {
  FairQueue queue(kPatience);
  queue.Push(1, "b", 1, kStart);
  for (FairQueue::Id id = 10; id < 20; ++id) queue.Push(id, "a", 100, kStart);
  for (int i = 0; i < 6; ++i) queue.Pop(kStart);
  for (FairQueue::Id id = 30; id < 35; ++id) queue.Push(id, "b", 100, kStart);
  // Turn and turn about from now on.
  std::map<char, int> served;
  for (int i = 0; i < 4; ++i) ++served[*queue.Pop(kStart) >= 30 ? 'b' : 'a'];
  EXPECT_EQ(served['a'], 2);
  EXPECT_EQ(served['b'], 2);
}

TEST(FairQueueTest, NoJobWaitsForEver) {
  FairQueue queue(kPatience);
  queue.Push(1, "expensive", 1'000'000, kStart);
  FairQueue::Id id = 1;
  Clock::time_point now = kStart;
  // Cheap jobs of ever new clients, one every second, and one served every second.
  int seconds = 0;
  for (;; ++seconds) {
    ++id;
    queue.Push(id, "cheap" + std::to_string(id), 1, now);
    if (*queue.Pop(now) == 1) break;
    ASSERT_LT(seconds, 200);
    now += std::chrono::seconds(1);
  }
  EXPECT_LE(seconds, 100);
}

TEST(FairQueueTest, WaitingMakesAJobCheaper) {
  FairQueue queue(kPatience);
  queue.Push(1, "a", 100, kStart);
  queue.Push(2, "b", 60, kStart + std::chrono::seconds(50));
  // 100 has become 50.
  EXPECT_EQ(*queue.Pop(kStart + std::chrono::seconds(50)), 1U);
}

TEST(FairQueueTest, ARemovedJobIsGone) {
  FairQueue queue(kPatience);
  queue.Push(1, "a", 1, kStart);
  queue.Push(2, "a", 1, kStart);
  queue.Push(3, "b", 1, kStart);
  EXPECT_TRUE(queue.Remove(1));
  EXPECT_TRUE(queue.Remove(3));
  EXPECT_FALSE(queue.Remove(3));
  EXPECT_EQ(PopAll(&queue), (std::vector<FairQueue::Id>{2}));
  EXPECT_FALSE(queue.Remove(2));
}

}  // namespace
}  // namespace limn
