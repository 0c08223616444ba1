// SPDX-License-Identifier: MIT
// How a program's heap gives memory back.
#pragma once

#include <malloc.h>

#include <cstddef>

namespace limn {

// For main() of programs that run jobs: freed memory of up to 256 MiB stays mapped, blocks below 64
// MiB come from it. By default glibc unmaps the arrays of a job of some 10,000 vertices after every
// stage, and getting fresh pages for the next costs more than the arithmetic on them. Process-wide;
// call it before threads start.
inline void KeepHeap() {
  constexpr int kMiB = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 64 * kMiB);
  mallopt(M_TRIM_THRESHOLD, 256 * kMiB);
}

// Gives the heap's free pages back to the system if there are more than so many bytes of them, as
// after a large job. Cost: up to milliseconds for each 100 MiB, in which others wait for the heap;
// for when nothing runs. Whether it did. Thread-safe.
inline bool TrimHeap(std::size_t keep) {
  if (mallinfo2().fordblks <= keep) return false;
  malloc_trim(0);
  return true;
}

}  // namespace limn
