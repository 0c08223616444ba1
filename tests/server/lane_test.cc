// SPDX-License-Identifier: MIT
// Places of a lane and the threads behind them.
#include "server/lane.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

TEST(LaneTest, HasWorkersPlusQueuePlacesAndNoMore) {
  Lane lane({.name = "test", .workers = 2, .queue_length = 1, .threads = 1});
  std::vector<Lane::Place> places;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const absl::StatusOr<std::uint64_t> position = lane.NextPosition();
    ASSERT_TRUE(position.ok());
    EXPECT_EQ(*position, i < 2 ? 0U : 1U);
    absl::StatusOr<Lane::Place> place = lane.Reserve();
    ASSERT_TRUE(place.ok());
    places.push_back(*std::move(place));
  }
  EXPECT_EQ(lane.Reserve().status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(lane.NextPosition().status().code(), absl::StatusCode::kResourceExhausted);
  places[1].Release();
  places[1].Release();
  EXPECT_EQ(lane.places_taken(), 2U);
  EXPECT_TRUE(lane.Reserve().ok());
}

TEST(LaneTest, RunsTasksInItsArena) {
  Lane lane({.name = "test", .workers = 1, .queue_length = 0, .threads = 3});
  absl::StatusOr<Lane::Place> place = lane.Reserve();
  ASSERT_TRUE(place.ok());
  std::promise<int> threads;
  place->Post([&] { threads.set_value(AvailableThreads()); });
  EXPECT_EQ(threads.get_future().get(), 3);
}

TEST(LaneTest, AReleasedPlaceTakesItsWaitingTaskBack) {
  Lane lane({.name = "test", .workers = 1, .queue_length = 1, .threads = 1});
  absl::StatusOr<Lane::Place> first = lane.Reserve();
  absl::StatusOr<Lane::Place> second = lane.Reserve();
  ASSERT_TRUE(first.ok() && second.ok());
  std::promise<void> go;
  std::promise<void> running;
  first->Post([&] {
    running.set_value();
    go.get_future().wait();
  });
  running.get_future().wait();
  const auto held = std::make_shared<int>(1);
  std::atomic<bool> ran = false;
  second->Post([held, &ran] { ran = true; });
  second->Release();
  EXPECT_EQ(held.use_count(), 1);
  go.set_value();
  lane.Stop();
  EXPECT_FALSE(ran);
}

TEST(WorkerThreadsTest, StopRunsWhatWasPosted) {
  std::atomic<int> ran = 0;
  WorkerThreads threads({.count = 3});
  for (int i = 0; i < 1000; ++i) threads.Post([&] { ++ran; });
  threads.Stop();
  EXPECT_EQ(ran, 1000);
}

TEST(WorkerThreadsTest, StopUntilTellsWhetherWorkIsLeft) {
  WorkerThreads threads({.count = 2});
  std::promise<void> go;
  std::promise<void> running;
  threads.Post([&] {
    running.set_value();
    go.get_future().wait();
  });
  running.get_future().wait();
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(threads.StopUntil(start + std::chrono::milliseconds(50)));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
  go.set_value();
  EXPECT_TRUE(threads.StopUntil(start + std::chrono::minutes(1)));
}

}  // namespace
}  // namespace limn
