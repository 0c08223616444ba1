// SPDX-License-Identifier: MIT
// A bounded number of slots.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>

namespace limn {

// Thread-safe. Must outlive its slots.
class Slots {
 public:
  // Holds one of the slots until it is released or gone. Not thread-safe itself.
  class Slot {
   public:
    Slot() = default;
    Slot(Slot&& other) noexcept : slots_(std::exchange(other.slots_, nullptr)) {}
    Slot& operator=(Slot&& other) noexcept {
      if (this != &other) {
        Release();
        slots_ = std::exchange(other.slots_, nullptr);
      }
      return *this;
    }
    ~Slot() { Release(); }
    // Safe to call again.
    void Release() {
      if (Slots* slots = std::exchange(slots_, nullptr); slots != nullptr) slots->GiveBack();
    }

   private:
    friend class Slots;
    explicit Slot(Slots* slots) : slots_(slots) {}
    Slots* slots_ = nullptr;
  };

  explicit Slots(std::uint64_t count) : count_(count) {}

  // Nothing when all are taken.
  [[nodiscard]] std::optional<Slot> Take() {
    const std::lock_guard lock(mutex_);
    if (taken_ >= count_) return std::nullopt;
    ++taken_;
    return Slot(this);
  }

  // Slots taken now.
  std::uint64_t taken() const {
    const std::lock_guard lock(mutex_);
    return taken_;
  }

 private:
  void GiveBack() {
    const std::lock_guard lock(mutex_);
    --taken_;
  }

  const std::uint64_t count_;
  mutable std::mutex mutex_;
  std::uint64_t taken_ = 0;
};

}  // namespace limn
