// SPDX-License-Identifier: MIT
// Decides, before anything is allocated for it, whether a job is taken: its size, its memory and
// its place in a lane.
#pragma once

#include <cstdint>
#include <mutex>

#include "absl/status/statusor.h"
#include "server/lane.h"
#include "server/limits.h"
#include "server/options_from_proto.h"

namespace limn {

// Bytes that a job needs at its peak: the encoded and the decoded mesh, the arrays of repair and of
// the engine, the encoded control mesh, the constraints, the certificate and the messages that
// wait, parameters among them. Saturates. With repair it reckons with the worst mesh of that size.
[[nodiscard]] std::uint64_t EstimateJobBytes(const JobSpec& spec);

// Thread-safe. Must outlive its tickets.
class Admission {
 public:
  // Memory that is set aside for a job until it is gone.
  class Reservation {
   public:
    Reservation() = default;
    Reservation(Reservation&& other) noexcept;
    Reservation& operator=(Reservation&& other) noexcept;
    ~Reservation() { Release(); }
    std::uint64_t bytes() const { return bytes_; }
    void Release();

   private:
    friend class Admission;
    Reservation(Admission* admission, std::uint64_t bytes) : admission_(admission), bytes_(bytes) {}
    Admission* admission_ = nullptr;
    std::uint64_t bytes_ = 0;
  };

  // What an admitted job holds: its place until it has been computed, its memory until its answer
  // has been taken.
  struct Ticket {
    Lane::Place place;
    Reservation memory;
  };

  // limits and lane must outlive it.
  Admission(const ServerLimits& limits, Lane& lane) : limits_(limits), lane_(lane) {}

  // Errors: those of wire::CheckHeader; LIMIT_EXCEEDED naming the limit. Nothing is held after an
  // error.
  [[nodiscard]] absl::StatusOr<Ticket> Admit(const JobSpec& spec);

  // Bytes set aside now.
  std::uint64_t reserved_bytes() const;

 private:
  // bytes: max_total_bytes at the most.
  [[nodiscard]] absl::StatusOr<Reservation> Reserve(std::uint64_t bytes);

  const ServerLimits& limits_;
  Lane& lane_;
  mutable std::mutex mutex_;
  std::uint64_t reserved_ = 0;
};

}  // namespace limn
