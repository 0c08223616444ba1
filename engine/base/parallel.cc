// SPDX-License-Identifier: MIT
// Without instrumentation by the thread sanitizer (engine/CMakeLists.txt), so that oneTBB's
// templates are treated as its library is; the callers of what is here say what holds between
// threads, see fork_join.h. Nothing of the standard library's templates, which would be shared
// with instrumented code.
#include "engine/base/parallel.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

namespace limn {

namespace parallel_internal {

void RunLoop(std::size_t n, std::size_t grain,
             bool (*body)(void* loop, std::size_t begin, std::size_t end), void* loop) {
  tbb::task_group_context group;
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, n, grain),
      [&](const tbb::blocked_range<std::size_t>& range) {
        if (!body(loop, range.begin(), range.end())) group.cancel_group_execution();
      },
      tbb::auto_partitioner(), group);
}

}  // namespace parallel_internal

int AvailableThreads() { return tbb::this_task_arena::max_concurrency(); }

struct ThreadArena::Arena {
  tbb::task_arena arena;
};

ThreadArena::ThreadArena(int threads)
    : arena_(new Arena{.arena = tbb::task_arena(threads == 0 ? tbb::task_arena::automatic
                                                             : (threads < 1 ? 1 : threads))}) {}

ThreadArena::~ThreadArena() = default;

int ThreadArena::threads() const { return arena_->arena.max_concurrency(); }

void ThreadArena::Enter(void (*f)(void* call), void* call) {
  arena_->arena.execute([f, call] { f(call); });
}

}  // namespace limn
