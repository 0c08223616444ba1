// SPDX-License-Identifier: MIT
// Tells the thread sanitizer what it cannot see inside oneTBB, which Debian does not instrument:
// what was written before a loop is there for its bodies, and what bodies write is there after it.
// Of two bodies neither comes first, so that their races are found. Nothing in other builds.
#pragma once

#if defined(__SANITIZE_THREAD__)
#include <sanitizer/tsan_interface.h>
#endif

namespace limn {

// Lives around one loop, on the stack of the thread that runs it.
class ForkJoin {
 public:
  // Lives around one body, in whatever thread; what it is given is its loop's.
  class Body {
   public:
    explicit Body(ForkJoin& loop) : loop_(loop) { Acquire(&loop_.fork_); }
    ~Body() { Release(&loop_.join_); }
    Body(const Body&) = delete;
    Body& operator=(const Body&) = delete;

   private:
    ForkJoin& loop_;
  };

  ForkJoin() { Release(&fork_); }
  ~ForkJoin() { Acquire(&join_); }
  ForkJoin(const ForkJoin&) = delete;
  ForkJoin& operator=(const ForkJoin&) = delete;

 private:
#if defined(__SANITIZE_THREAD__)
  static void Release(void* at) { __tsan_release(at); }
  static void Acquire(void* at) { __tsan_acquire(at); }
#else
  static void Release(void* /*at*/) {}
  static void Acquire(void* /*at*/) {}
#endif

  // Only their addresses mean something.
  char fork_ = 0;
  char join_ = 0;
};

}  // namespace limn
