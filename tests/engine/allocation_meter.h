// SPDX-License-Identifier: MIT
// Counts the bytes that the process holds on the heap in large blocks.
#pragma once

#include <cstddef>

namespace limn {

// While one lives, blocks of at least kSmallest bytes are counted from their allocation to their
// release, whichever thread does it. One at a time.
class AllocationMeter {
 public:
  static constexpr std::size_t kSmallest = 1024;

  AllocationMeter();
  ~AllocationMeter();
  AllocationMeter(const AllocationMeter&) = delete;
  AllocationMeter& operator=(const AllocationMeter&) = delete;

  // Most bytes held at once since the construction.
  std::size_t peak() const;
};

}  // namespace limn
