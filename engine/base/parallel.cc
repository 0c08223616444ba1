// SPDX-License-Identifier: MIT
// Without instrumentation by the thread sanitizer (engine/CMakeLists.txt), so that oneTBB's
// templates are treated as its library is; the callers of what is here say what holds between
// threads, see fork_join.h. Nothing of the standard library's templates, which would be shared
// with instrumented code.
#include "engine/base/parallel.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>
#include <oneapi/tbb/task_scheduler_observer.h>
#include <sys/resource.h>
#include <unistd.h>

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

namespace {

// Gives oneTBB's own threads a nice value while they are in an arena.
class Niceness final : public tbb::task_scheduler_observer {
 public:
  Niceness(tbb::task_arena& arena, int value)
      : tbb::task_scheduler_observer(arena),
        value_(getpriority(PRIO_PROCESS, static_cast<id_t>(getpid())) + value) {
    observe(true);
  }
  Niceness(const Niceness&) = delete;
  Niceness& operator=(const Niceness&) = delete;
  ~Niceness() override { observe(false); }

  void on_scheduler_entry(bool is_worker) override {
    // On Linux the value is one thread's; 0 is the caller.
    if (is_worker) (void)setpriority(PRIO_PROCESS, 0, value_);
  }

 private:
  const int value_;
};

int AtLeastOne(int value) { return value < 1 ? 1 : value; }

}  // namespace

struct ThreadArena::Arena {
  explicit Arena(const Options& options)
      : arena((options.threads == 0 ? tbb::info::default_concurrency()
                                    : AtLeastOne(options.threads)) +
                  AtLeastOne(options.callers) - 1,
              static_cast<unsigned>(AtLeastOne(options.callers))),
        niceness(options.niceness.has_value() ? new Niceness(arena, *options.niceness) : nullptr) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;
  ~Arena() { delete niceness; }

  tbb::task_arena arena;
  Niceness* const niceness;
};

ThreadArena::ThreadArena(const Options& options) : arena_(new Arena(options)) {}

ThreadArena::~ThreadArena() = default;

int ThreadArena::threads() const { return arena_->arena.max_concurrency(); }

void ThreadArena::Enter(void (*f)(void* call), void* call) {
  arena_->arena.execute([f, call] { f(call); });
}

}  // namespace limn
