// SPDX-License-Identifier: MIT
// Arrays for bulk data: std::vector that does not zero what will be overwritten and asks for huge
// pages where it is large. Writing fresh 4 KiB pages costs several times the arithmetic here.
#pragma once

#include <sys/mman.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace limn {

// Buffers are aligned to cache lines, large ones to huge pages; the last one is theirs to the end.
inline constexpr std::size_t kCacheLine = 64;
inline constexpr std::size_t kHugePage = std::size_t{2} << 20;
inline constexpr std::size_t kHugeFrom = std::size_t{4} << 20;

// Bytes that a buffer takes for `bytes` of elements. A double, for estimates beyond all memory.
inline double BufferBytes(double bytes) {
  const double unit = bytes >= kHugeFrom ? kHugePage : kCacheLine;
  return std::ceil(bytes / unit) * unit;
}

// Allocator of Buffer. Elements are default-initialised (left as they are for plain types), memory
// is aligned to cache lines, and to huge pages from 4 MiB upwards. Throws std::bad_alloc.
template <class T>
class UninitializedAllocator {
 public:
  using value_type = T;
  using is_always_equal = std::true_type;

  UninitializedAllocator() = default;
  template <class U>
  UninitializedAllocator(const UninitializedAllocator<U>& /*other*/) noexcept {}  // NOLINT

  T* allocate(std::size_t n) {
    // Room for rounding up, below the largest object.
    if (n > (PTRDIFF_MAX - kHugePage) / sizeof(T)) throw std::bad_array_new_length();
    std::size_t bytes = n * sizeof(T);
    const bool huge = bytes >= kHugeFrom;
    const std::size_t alignment = huge ? kHugePage : kCacheLine;
    bytes = (bytes + alignment - 1) / alignment * alignment;
    void* memory = std::aligned_alloc(alignment, bytes == 0 ? alignment : bytes);
    if (memory == nullptr) throw std::bad_alloc();
    // A refusal only costs speed.
    if (huge) (void)madvise(memory, bytes, MADV_HUGEPAGE);
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t /*n*/) noexcept { std::free(memory); }

  template <class U>
  void construct(U* at) noexcept(std::is_nothrow_default_constructible_v<U>) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Args>
  void construct(U* at, Args&&... args) {
    std::construct_at(at, std::forward<Args>(args)...);
  }

  friend bool operator==(const UninitializedAllocator& /*a*/, const UninitializedAllocator& /*b*/) {
    return true;
  }
};

// A std::vector whose resize(n) leaves new plain elements uninitialised; resize(n, value) sets
// them.
template <class T>
using Buffer = std::vector<T, UninitializedAllocator<T>>;

}  // namespace limn
