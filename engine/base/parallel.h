// SPDX-License-Identifier: MIT
// The one seam to oneTBB. All loops are gather loops: each iteration writes only what it owns, so
// results do not depend on the number of threads. Threads are those of the arena that the caller
// is in; see ThreadArena.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/fork_join.h"

namespace limn {
namespace parallel_internal {

// Calls body(loop, begin, end) for disjoint ranges of at least `grain`, all but the last, that
// cover [0, n), until one of them returns false.
void RunLoop(std::size_t n, std::size_t grain,
             bool (*body)(void* loop, std::size_t begin, std::size_t end), void* loop);

}  // namespace parallel_internal

// Iterations per chunk where a loop does not say otherwise: long enough to hide the scheduler
// (some 10 us of work), short enough to stop soon after a cancel. Loops below it run serially.
inline constexpr std::size_t kDefaultGrain = 2048;

// Calls body(begin, end) for disjoint ranges that cover [0, n), in parallel, in no given order.
// Returns the context's status when it was stopped; some ranges were not visited then.
template <class Body>
[[nodiscard]] absl::Status ParallelFor(const Context& context, std::size_t n, std::size_t grain,
                                       const Body& body) {
  if (context.stop_requested()) return context.Check();
  if (n <= grain) {
    if (n > 0) body(std::size_t{0}, n);
    return absl::OkStatus();
  }
  struct Loop {
    const Context& context;
    const std::size_t grain;
    const Body& body;
    // Last, so that all of the loop is there when it says so.
    ForkJoin fork_join = {};
  } loop = {.context = context, .grain = grain, .body = body};
  const auto visit = [](void* at, std::size_t begin, std::size_t end) {
    Loop& self = *static_cast<Loop*>(at);
    const ForkJoin::Body scope(self.fork_join);
    // Ranges larger than the grain are cut up, so that a stop is seen soon.
    for (; begin < end; begin += self.grain) {
      if (self.context.stop_requested()) return false;
      self.body(begin, std::min(begin + self.grain, end));
    }
    return true;
  };
  parallel_internal::RunLoop(n, grain, visit, &loop);
  return context.Check();
}

template <class Body>
[[nodiscard]] absl::Status ParallelFor(const Context& context, std::size_t n, const Body& body) {
  return ParallelFor(context, n, kDefaultGrain, body);
}

// Calls body(begin, end) for the chunks of [0, n) one after the other, in this thread: for what
// depends on its order. Returns the context's status when it was stopped; the rest was not visited
// then.
template <class Body>
[[nodiscard]] absl::Status ForInOrder(const Context& context, std::size_t n, const Body& body) {
  for (std::size_t begin = 0; begin < n; begin += kDefaultGrain) {
    if (context.stop_requested()) break;
    body(begin, std::min(begin + kDefaultGrain, n));
  }
  return context.Check();
}

// Largest value of body(begin, end) over disjoint ranges that cover [0, n), and at least
// `identity`. The maximum does not depend on the order, so neither does the result.
template <class Body>
[[nodiscard]] absl::Status ParallelMax(const Context& context, std::size_t n, double identity,
                                       const Body& body, double* result) {
  std::atomic<double> largest = identity;
  absl::Status status = ParallelFor(context, n, [&](std::size_t begin, std::size_t end) {
    const double found = body(begin, end);
    double before = largest.load(std::memory_order_relaxed);
    while (before < found &&
           !largest.compare_exchange_weak(before, found, std::memory_order_relaxed)) {
    }
  });
  *result = largest.load(std::memory_order_relaxed);
  return status;
}

// Calls body(block, begin, end) for the blocks of fixed size `block_size` that cover [0, n). Which
// iterations form a block does not depend on the threads: partial results kept per block can be
// combined in block order to the same bits.
template <class Body>
[[nodiscard]] absl::Status ParallelBlocks(const Context& context, std::size_t n,
                                          std::size_t block_size, const Body& body) {
  const std::size_t blocks = (n + block_size - 1) / block_size;
  return ParallelFor(context, blocks, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t block = first; block < last; ++block) {
      body(block, block * block_size, std::min(n, (block + 1) * block_size));
    }
  });
}

// Block size of scans and ordered sums.
inline constexpr std::size_t kScanBlock = 8192;

// *sum = sum of f(i) over [0, n), by blocks of kScanBlock in their order: same bits for any number
// of threads. Errors: as ParallelFor.
template <class F>
[[nodiscard]] absl::Status ParallelSum(const Context& context, std::size_t n, const F& f,
                                       double* sum) {
  std::vector<double> part((n + kScanBlock - 1) / kScanBlock, 0);
  absl::Status status = ParallelBlocks(context, n, kScanBlock,
                                       [&](std::size_t block, std::size_t begin, std::size_t end) {
                                         double total = 0;
                                         for (std::size_t i = begin; i < end; ++i) total += f(i);
                                         part[block] = total;
                                       });
  *sum = 0;
  for (const double p : part) *sum += p;
  return status;
}

// Ordered numbering: count(begin, end) says how many items the range holds; then
// place(begin, end, first) is called with the number of items before `begin`. Returns the total.
template <class Count, class Place>
[[nodiscard]] absl::Status ParallelNumber(const Context& context, std::size_t n, const Count& count,
                                          const Place& place, std::uint64_t* total) {
  std::vector<std::uint64_t> first((n + kScanBlock - 1) / kScanBlock + 1, 0);
  if (absl::Status status =
          ParallelBlocks(context, n, kScanBlock,
                         [&](std::size_t block, std::size_t begin, std::size_t end) {
                           first[block + 1] = count(begin, end);
                         });
      !status.ok()) {
    return status;
  }
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  *total = first.back();
  return ParallelBlocks(context, n, kScanBlock,
                        [&](std::size_t block, std::size_t begin, std::size_t end) {
                          place(begin, end, first[block]);
                        });
}

// Replaces counts by the sums of all counts before them; counts must have one more element than
// there are items, the last of which becomes the total. Sums are the caller's to bound.
[[nodiscard]] inline absl::Status ParallelExclusiveSum(const Context& context,
                                                       absl::Span<std::uint32_t> counts) {
  if (counts.empty()) return absl::OkStatus();
  const std::size_t n = counts.size() - 1;
  counts[n] = 0;
  std::uint64_t total = 0;
  absl::Status status = ParallelNumber(
      context, n,
      [&](std::size_t begin, std::size_t end) {
        std::uint64_t sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += counts[i];
        return sum;
      },
      [&](std::size_t begin, std::size_t end, std::uint64_t first) {
        for (std::size_t i = begin; i < end; ++i) {
          const std::uint32_t count = counts[i];
          counts[i] = static_cast<std::uint32_t>(first);
          first += count;
        }
      },
      &total);
  counts[n] = static_cast<std::uint32_t>(total);
  return status;
}

// Threads that loops started here may use.
[[nodiscard]] int AvailableThreads();

// Threads to run jobs on. Loops called inside Execute use at most `threads` threads, the caller's
// among them. Thread-safe; several jobs may share an arena.
class ThreadArena {
 public:
  struct Options {
    // Threads that a lone caller's loops use; 1 or more, 0 means one per processor that this
    // process may use.
    int threads = 0;
    // Callers that may be in Execute at a time, 1 or more, each of which runs what it brought at
    // once and itself. One more than that would wait for a thread, or have its work run inside of
    // another's.
    int callers = 1;
    // Nice value (setpriority(2)) of the threads that help, relative to the process's; none leaves
    // theirs alone. Where the system does not allow to go back to a lower one, they keep the
    // higher.
    std::optional<int> niceness = std::nullopt;
  };
  explicit ThreadArena(const Options& options);
  // For one caller.
  explicit ThreadArena(int threads) : ThreadArena(Options{.threads = threads}) {}
  ~ThreadArena();
  ThreadArena(const ThreadArena&) = delete;
  ThreadArena& operator=(const ThreadArena&) = delete;

  // Runs f() in this arena and returns its result.
  template <class F>
  auto Execute(F&& f) {
    using Result = std::invoke_result_t<F&>;
    if constexpr (std::is_void_v<Result>) {
      Enter(f);
    } else {
      std::optional<Result> result;
      Enter([&] { result.emplace(f()); });
      return *std::move(result);
    }
  }

  // Threads of this arena, callers among them.
  int threads() const;

 private:
  struct Arena;

  template <class F>
  void Enter(F&& f) {
    struct Call {
      std::remove_reference_t<F>& f;
      ForkJoin fork_join = {};
    } call = {.f = f};
    const auto run = [](void* at) {
      Call& self = *static_cast<Call*>(at);
      const ForkJoin::Body scope(self.fork_join);
      self.f();
    };
    Enter(run, &call);
  }
  // Calls f(call), here or in another thread.
  void Enter(void (*f)(void* call), void* call);

  const std::unique_ptr<Arena> arena_;
};

}  // namespace limn
