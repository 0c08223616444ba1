// SPDX-License-Identifier: MIT
// Allocations are seen through the sanitizers' hooks where there is a sanitizer, and by standing in
// for the C library's functions otherwise.
#include "tests/engine/allocation_meter.h"

#include <malloc.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <utility>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LIMN_SANITIZED 1
// From sanitizer/allocator_interface.h, which g++'s packages do not bring.
extern "C" int __sanitizer_install_malloc_and_free_hooks(  // NOLINT
    void (*allocated)(const volatile void*, std::size_t), void (*released)(const volatile void*));
#endif

namespace limn {
namespace {

// No constructors and no allocations: this runs inside malloc, also before main.
struct Books {
  std::atomic<bool> open{false};
  std::atomic_flag busy = ATOMIC_FLAG_INIT;
  std::array<std::pair<const volatile void*, std::size_t>, 65536> blocks{};
  std::size_t count = 0;
  std::size_t held = 0;
  std::size_t peak = 0;
};
constinit Books books;

class Lock {
 public:
  Lock() {
    while (books.busy.test_and_set(std::memory_order_acquire)) {
    }
  }
  ~Lock() { books.busy.clear(std::memory_order_release); }
};

void Allocated(const volatile void* block, std::size_t size) {
  if (!books.open.load(std::memory_order_relaxed)) return;
  if (block == nullptr || size < AllocationMeter::kSmallest) return;
  const Lock lock;
  if (books.count == books.blocks.size()) std::abort();
  books.blocks[books.count++] = {block, size};
  books.held += size;
  books.peak = std::max(books.peak, books.held);
}

void Released(const volatile void* block) {
  if (!books.open.load(std::memory_order_relaxed) || block == nullptr) return;
  const Lock lock;
  // The latest blocks go first most often.
  for (std::size_t i = books.count; i-- > 0;) {
    if (books.blocks[i].first != block) continue;
    books.held -= books.blocks[i].second;
    books.blocks[i] = books.blocks[--books.count];
    return;
  }
}

}  // namespace

AllocationMeter::AllocationMeter() {
#ifdef LIMN_SANITIZED
  static const int kInstalled = __sanitizer_install_malloc_and_free_hooks(Allocated, Released);
  if (kInstalled == 0) std::abort();
#endif
  const Lock lock;
  books.count = 0;
  books.held = 0;
  books.peak = 0;
  books.open = true;
}

AllocationMeter::~AllocationMeter() { books.open = false; }

std::size_t AllocationMeter::peak() const {
  const Lock lock;
  return books.peak;
}

}  // namespace limn

// What g++ 12's thread sanitizer calls no hooks for.
#ifdef __SANITIZE_THREAD__
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  void* const block = memalign(alignment, size);
  limn::Allocated(block, size);
  return block;
}
#endif

#ifndef LIMN_SANITIZED
// The C library's own functions under the names by which it lets programs reach them.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT
void __libc_free(void* block);                                   // NOLINT

void* malloc(std::size_t size) noexcept {
  void* const block = __libc_malloc(size);
  limn::Allocated(block, size);
  return block;
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  void* const block = __libc_memalign(alignment, size);
  limn::Allocated(block, size);
  return block;
}

void free(void* block) noexcept {
  limn::Released(block);
  __libc_free(block);
}
}
#endif
