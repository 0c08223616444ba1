// SPDX-License-Identifier: MIT
// Sets of numbers that are merged two at a time, with path halving.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "engine/base/buffer.h"

namespace limn {

// The numbers 0 to size - 1, at first each in a set of its own. The smallest number of a set is its
// name, whatever the order of the merges. Cost: near constant per call; 4 bytes a number. Not
// thread-safe, Find neither: it shortens paths.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }

  std::uint32_t Find(std::uint32_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }

  void Merge(std::uint32_t a, std::uint32_t b) {
    a = Find(a);
    b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  Buffer<std::uint32_t> parent_;
};

}  // namespace limn
