// SPDX-License-Identifier: MIT
#include "engine/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <set>
#include <thread>
#include <vector>

#include "tests/oracle/expect.h"

namespace limn {
namespace {

constexpr std::size_t kSizes[] = {0, 1, 2, 7, 2047, 2048, 2049, 8191, 8192, 8193, 16384, 100003};

TEST(Parallel, ForVisitsEveryIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    for (const std::size_t n : kSizes) {
      for (const std::size_t grain : {std::size_t{1}, std::size_t{100}, kDefaultGrain}) {
        std::vector<std::atomic<int>> visits(n);
        const absl::Status status = oracle::WithThreads(threads, [&] {
          return ParallelFor(Context(), n, grain, [&](std::size_t begin, std::size_t end) {
            EXPECT_LT(begin, end);
            EXPECT_LE(end - begin, grain);
            for (std::size_t i = begin; i < end; ++i) ++visits[i];
          });
        });
        ASSERT_TRUE(status.ok());
        for (const auto& count : visits) ASSERT_EQ(count, 1) << n << ", grain " << grain;
      }
    }
  }
}

TEST(Parallel, ForStopsWithinOneChunkPerThread) {
  for (const int threads : {1, 2, 5}) {
    const Context context;
    std::atomic<int> chunks{0};
    std::atomic<int> after{0};
    const absl::Status status = oracle::WithThreads(threads, [&] {
      return ParallelFor(context, 1000000, 100, [&](std::size_t, std::size_t) {
        if (context.stop_requested()) ++after;
        if (++chunks == 20) context.Cancel();
      });
    });
    oracle::ExpectError(status, {Reason::kCancelled});
    EXPECT_GE(chunks, 20);
    // Each thread may have been about to start a chunk.
    EXPECT_LE(after, threads);
  }
}

TEST(Parallel, InOrderVisitsEveryIndexInItsOrderUntilItIsStopped) {
  for (const std::size_t n : kSizes) {
    std::size_t next = 0;
    const auto count = [&](std::size_t begin, std::size_t end) {
      EXPECT_EQ(begin, next);
      EXPECT_LE(end - begin, kDefaultGrain);
      next = end;
    };
    ASSERT_TRUE(ForInOrder(Context(), n, count).ok());
    EXPECT_EQ(next, n);
  }
  const Context context;
  std::size_t chunks = 0;
  oracle::ExpectError(ForInOrder(context, 1000000,
                                 [&](std::size_t, std::size_t) {
                                   if (++chunks == 3) context.Cancel();
                                 }),
                      {Reason::kCancelled});
  EXPECT_EQ(chunks, 3U);
}

TEST(Parallel, ForDoesNotStartWhenTheJobIsStopped) {
  const Context cancelled;
  cancelled.Cancel();
  Context late;
  late.set_deadline(Context::Clock::now());
  const auto fail = [](std::size_t, std::size_t) { ADD_FAILURE(); };
  for (const std::size_t n : {1, 100000}) {
    oracle::ExpectError(ParallelFor(cancelled, n, fail), {Reason::kCancelled});
    oracle::ExpectError(ParallelFor(late, n, fail), {Reason::kDeadlineExceeded});
  }
}

TEST(Parallel, BlocksAreTheSameForAnyNumberOfThreads) {
  for (const int threads : {1, 2, 5}) {
    for (const std::size_t n : kSizes) {
      std::vector<std::pair<std::size_t, std::size_t>> blocks((n + 99) / 100);
      const absl::Status status = oracle::WithThreads(threads, [&] {
        return ParallelBlocks(Context(), n, 100,
                              [&](std::size_t block, std::size_t begin, std::size_t end) {
                                blocks.at(block) = {begin, end};
                              });
      });
      ASSERT_TRUE(status.ok());
      for (std::size_t block = 0; block < blocks.size(); ++block) {
        EXPECT_EQ(blocks[block].first, 100 * block);
        EXPECT_EQ(blocks[block].second, std::min(n, 100 * block + 100));
      }
    }
  }
}

TEST(Parallel, NumberCountsInOrder) {
  for (const int threads : {1, 2, 5}) {
    for (const std::size_t n : kSizes) {
      // Numbers the multiples of 3.
      std::vector<std::uint64_t> number(n, 0);
      std::uint64_t total = 0;
      const absl::Status status = oracle::WithThreads(threads, [&] {
        return ParallelNumber(
            Context(), n,
            [](std::size_t begin, std::size_t end) { return (end + 2) / 3 - (begin + 2) / 3; },
            [&](std::size_t begin, std::size_t end, std::uint64_t first) {
              for (std::size_t i = begin; i < end; ++i) {
                if (i % 3 == 0) number[i] = first++;
              }
            },
            &total);
      });
      ASSERT_TRUE(status.ok());
      EXPECT_EQ(total, (n + 2) / 3);
      for (std::size_t i = 0; i < n; i += 3) ASSERT_EQ(number[i], i / 3);
    }
  }
}

TEST(Parallel, NumberStopsWhenTheJobIsStopped) {
  const Context cancelled;
  cancelled.Cancel();
  std::uint64_t total = 0;
  oracle::ExpectError(ParallelNumber(
                          cancelled, 10, [](std::size_t, std::size_t) { return 1; },
                          [](std::size_t, std::size_t, std::uint64_t) { ADD_FAILURE(); }, &total),
                      {Reason::kCancelled});
}

TEST(Parallel, ExclusiveSumIsThatOfTheStandardLibrary) {
  for (const int threads : {1, 2, 5}) {
    for (const std::size_t n : kSizes) {
      std::vector<std::uint32_t> counts(n + 1);
      for (std::size_t i = 0; i < n; ++i) counts[i] = static_cast<std::uint32_t>(i * 7 % 11);
      // The last element is overwritten by the total.
      std::vector<std::uint32_t> expected(n + 1);
      std::exclusive_scan(counts.begin(), counts.end(), expected.begin(), 0U);
      counts[n] = 12345;
      const absl::Status status = oracle::WithThreads(
          threads, [&] { return ParallelExclusiveSum(Context(), absl::MakeSpan(counts)); });
      ASSERT_TRUE(status.ok());
      EXPECT_EQ(counts, expected);
    }
  }
  EXPECT_TRUE(ParallelExclusiveSum(Context(), {}).ok());
}

TEST(Parallel, MaxIsThatOfAllRangesAndTheIdentity) {
  for (const int threads : {1, 2, 5}) {
    for (const std::size_t n : kSizes) {
      for (const std::size_t peak : {std::size_t{0}, n / 2, n - 1}) {
        double result = 0;
        const absl::Status status = oracle::WithThreads(threads, [&] {
          return ParallelMax(
              Context(), n, -3,
              [&](std::size_t begin, std::size_t end) {
                return begin <= peak && peak < end ? 5.0 : -7.0;
              },
              &result);
        });
        ASSERT_TRUE(status.ok());
        EXPECT_EQ(result, n == 0 ? -3 : 5);
        ASSERT_TRUE(ParallelMax(
                        Context(), n, -3, [](std::size_t, std::size_t) { return -7.0; }, &result)
                        .ok());
        EXPECT_EQ(result, -3);
      }
    }
  }
}

TEST(Parallel, MaxDoesNotStartWhenTheJobIsStopped) {
  const Context cancelled;
  cancelled.Cancel();
  for (const std::size_t n : {1, 100000}) {
    double result = 0;
    oracle::ExpectError(ParallelMax(
                            cancelled, n, 0,
                            [](std::size_t, std::size_t) {
                              ADD_FAILURE();
                              return 1.0;
                            },
                            &result),
                        {Reason::kCancelled});
  }
}

TEST(Parallel, ArenaRunsWithSoManyThreads) {
  EXPECT_EQ(ThreadArena(1).threads(), 1);
  EXPECT_EQ(ThreadArena(3).threads(), 3);
  EXPECT_GE(ThreadArena(0).threads(), 1);
  EXPECT_EQ(ThreadArena(-4).threads(), 1);
  ThreadArena one(1);
  std::set<std::thread::id> ids;
  const int answer = one.Execute([&] {
    EXPECT_TRUE(ParallelFor(Context(), 10000, 1, [&](std::size_t, std::size_t) {
                  ids.insert(std::this_thread::get_id());
                }).ok());
    return 42;
  });
  EXPECT_EQ(answer, 42);
  EXPECT_EQ(ids, std::set<std::thread::id>{std::this_thread::get_id()});
}

}  // namespace
}  // namespace limn
