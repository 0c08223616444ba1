// SPDX-License-Identifier: MIT
// How a program's heap gives memory back.
#pragma once

#include <malloc.h>

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

}  // namespace limn
