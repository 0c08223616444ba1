// SPDX-License-Identifier: MIT
// Decides, before anything is allocated for it, whether a job is taken: its size, its memory, its
// turn to upload and its place in a lane.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "server/job_memory.h"
#include "server/lane.h"
#include "server/limits.h"
#include "server/options_from_proto.h"
#include "server/slots.h"

namespace limn {

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
    // Gives back what is above so many bytes.
    void Shrink(std::uint64_t bytes);

   private:
    friend class Admission;
    Admission* admission_ = nullptr;
    std::uint64_t bytes_ = 0;
  };

  // What an admitted job holds: first its turn to upload, then its place until it has been
  // computed; its memory until its answer has been taken.
  struct Ticket {
    Slots::Slot upload;
    // Where it will run.
    Lane* lane = nullptr;
    LaneRequest request;
    Lane::Place place;
    Reservation memory;
    // What EstimateJobBytes says.
    std::uint64_t estimate = 0;
    // Position that its place would have if its upload were complete.
    std::uint64_t position = 0;
  };

  // limits and lanes must outlive it.
  Admission(const ServerLimits& limits, Lanes& lanes)
      : limits_(limits), lanes_(lanes), uploads_(limits.max_uploads) {}

  // For a job whose upload begins. Only what the upload takes is set aside: who uploads slowly must
  // not hold a place and memory that another job could use. But a job for which there is no place
  // or no memory now is refused, which saves its upload. client: whose job it is, for fair shares.
  //
  // Errors: those of wire::CheckHeader; LIMIT_EXCEEDED naming the limit. Nothing is held after an
  // error.
  [[nodiscard]] absl::StatusOr<Ticket> Admit(const JobSpec& spec, const std::string& client = "");

  // For a job whose upload is complete: sets its memory aside, and trades its turn to upload for a
  // place in its lane. Errors: LIMIT_EXCEEDED with limit max-total-bytes, queue-length, queue-bytes
  // or queue-milliseconds; the job cannot go on then.
  [[nodiscard]] absl::Status Enqueue(Ticket* ticket);

  // Has the reservation hold at least this many bytes, now that more is known than the header
  // claimed. Errors: LIMIT_EXCEEDED with limit max-job-bytes or max-total-bytes; the reservation is
  // as before then. Not thread-safe as to the reservation.
  [[nodiscard]] absl::Status Grow(std::uint64_t bytes, Reservation* reservation);

  // Bytes set aside now.
  std::uint64_t reserved_bytes() const;

  // Uploads under way.
  std::uint64_t uploads() const { return uploads_.taken(); }

 private:
  // level_chosen: by the engine, so that a lower level would not help.
  [[nodiscard]] absl::Status CheckJobBytes(std::uint64_t bytes, bool level_chosen = false) const;
  // With the mutex held.
  [[nodiscard]] absl::Status CheckTotal(std::uint64_t more) const;

  const ServerLimits& limits_;
  Lanes& lanes_;
  Slots uploads_;
  mutable std::mutex mutex_;
  std::uint64_t reserved_ = 0;
};

}  // namespace limn
