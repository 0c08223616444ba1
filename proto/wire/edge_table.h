// SPDX-License-Identifier: MIT
// A map from pairs of vertices to a number: open addressing, linear probing, no erasing.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "engine/base/buffer.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::wire {

class EdgeTable {
 public:
  // Room for `expected` pairs at once; more make it grow. Throws std::bad_alloc.
  explicit EdgeTable(std::size_t expected) { Allocate(std::bit_ceil(expected * 3 / 2 + 8)); }

  // The number of the pair (a, b), inserted as `value` if the pair was not there. Valid until the
  // next insertion.
  std::uint32_t* FindOrInsert(Index a, Index b, std::uint32_t value) {
    Slot* slot = Probe(Key(a, b));
    if (slot->key != kFree) return &slot->value;
    if (3 * (size_ + 1) > 2 * slots_.size()) {
      Grow();
      slot = Probe(Key(a, b));
    }
    ++size_;
    *slot = {Key(a, b), value};
    return &slot->value;
  }

  // The number of the pair (a, b), or nullptr.
  std::uint32_t* Find(Index a, Index b) {
    Slot* slot = Probe(Key(a, b));
    return slot->key == kFree ? nullptr : &slot->value;
  }

 private:
  struct Slot {
    std::uint64_t key;
    std::uint32_t value;
  };
  // No pair: vertex kNoIndex does not exist.
  static constexpr std::uint64_t kFree = ~std::uint64_t{0};

  static std::uint64_t Key(Index a, Index b) { return std::uint64_t{a} << 32 | b; }

  void Allocate(std::size_t slots) {
    slots_.assign(slots, Slot{kFree, 0});
    shift_ = 64 - std::countr_zero(slots);
  }

  void Grow() {
    Buffer<Slot> old = std::move(slots_);
    Allocate(2 * old.size());
    for (const Slot& slot : old) {
      if (slot.key != kFree) *Probe(slot.key) = slot;
    }
  }

  Slot* Probe(std::uint64_t key) {
    // Both factors spread consecutive numbers; the fold between them lets every bit of the key
    // count in the upper bits that are used.
    std::uint64_t hash = key * 0x9e3779b97f4a7c15U;
    hash = (hash ^ hash >> 32) * 0xd6e8feb86659fd93U;
    std::size_t at = hash >> shift_;
    const std::size_t mask = slots_.size() - 1;
    while (slots_[at].key != kFree && slots_[at].key != key) at = (at + 1) & mask;
    return &slots_[at];
  }

  Buffer<Slot> slots_;
  std::size_t size_ = 0;
  int shift_ = 0;
};

}  // namespace limn::wire
