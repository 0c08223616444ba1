// SPDX-License-Identifier: MIT
#include "server/admission.h"

#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine/base/byte_text.h"
#include "engine/base/error.h"
#include "server/job_cost.h"

namespace limn {
namespace {

absl::Status TooLarge(absl::string_view field, absl::string_view message, absl::string_view limit,
                      absl::string_view remedy) {
  return MakeError(absl::StrCat(field, ": ", message, " (limit ", limit, ")"),
                   {.reason = Reason::kLimitExceeded,
                    .field = std::string(field),
                    .remedy = std::string(remedy),
                    .limit = std::string(limit)});
}

absl::Status Busy(absl::string_view message, absl::string_view limit) {
  return MakeError(absl::StrCat("the server is busy: ", message, " (limit ", limit, ")"),
                   {.reason = Reason::kLimitExceeded,
                    .remedy = "Try again a little later",
                    .limit = std::string(limit),
                    .retryable = true});
}

}  // namespace

Admission::Reservation::Reservation(Reservation&& other) noexcept
    : admission_(std::exchange(other.admission_, nullptr)),
      bytes_(std::exchange(other.bytes_, 0)) {}

Admission::Reservation& Admission::Reservation::operator=(Reservation&& other) noexcept {
  if (this == &other) return *this;
  Release();
  admission_ = std::exchange(other.admission_, nullptr);
  bytes_ = std::exchange(other.bytes_, 0);
  return *this;
}

void Admission::Reservation::Release() {
  Admission* admission = std::exchange(admission_, nullptr);
  if (admission == nullptr) return;
  const std::lock_guard lock(admission->mutex_);
  admission->reserved_ -= std::exchange(bytes_, 0);
}

void Admission::Reservation::Shrink(std::uint64_t bytes) {
  if (bytes >= bytes_) return;
  const std::lock_guard lock(admission_->mutex_);
  admission_->reserved_ -= bytes_ - bytes;
  bytes_ = bytes;
}

absl::StatusOr<Admission::Ticket> Admission::Admit(const JobSpec& spec, const std::string& client) {
  LIMN_RETURN_IF_ERROR(
      wire::CheckHeader(EngineLimits(limits_), spec.mesh, {.any_arity = spec.repair}));
  if (spec.mesh.byte_count() > limits_.max_mesh_bytes) {
    return TooLarge("mesh.byte_count",
                    absl::StrCat(ByteText(spec.mesh.byte_count()), " are more than ",
                                 ByteText(limits_.max_mesh_bytes)),
                    "max-mesh-bytes", "Use a smaller mesh or a smaller encoding");
  }
  if (spec.engine.level > limits_.max_level) {
    return TooLarge("surface.level",
                    absl::StrCat(spec.engine.level, " is above ", limits_.max_level), "max-level",
                    "Ask for a lower level");
  }
  Ticket ticket;
  ticket.estimate = EstimateJobBytes(spec);
  LIMN_RETURN_IF_ERROR(CheckJobBytes(ticket.estimate, spec.engine.chord_tolerance.has_value()));
  ticket.request = {
      .client = client, .bytes = ticket.estimate, .milliseconds = EstimateMilliseconds(spec)};
  ticket.lane = &lanes_.For(ticket.request.milliseconds);
  LIMN_ASSIGN_OR_RETURN(ticket.position, ticket.lane->NextPosition(ticket.request));
  std::optional<Slots::Slot> upload = uploads_.Take();
  if (!upload.has_value()) {
    return Busy(absl::StrCat(limits_.max_uploads, " meshes are arriving"), "max-uploads");
  }
  ticket.upload = *std::move(upload);
  {
    const std::lock_guard lock(mutex_);
    LIMN_RETURN_IF_ERROR(CheckTotal(ticket.estimate));
  }
  LIMN_RETURN_IF_ERROR(Grow(EstimateUploadBytes(spec), &ticket.memory));
  return ticket;
}

absl::Status Admission::Enqueue(Ticket* ticket) {
  LIMN_RETURN_IF_ERROR(Grow(ticket->estimate, &ticket->memory));
  LIMN_ASSIGN_OR_RETURN(ticket->place, ticket->lane->Reserve(ticket->request));
  ticket->upload.Release();
  return absl::OkStatus();
}

absl::Status Admission::Grow(std::uint64_t bytes, Reservation* reservation) {
  if (bytes <= reservation->bytes_) return absl::OkStatus();
  LIMN_RETURN_IF_ERROR(CheckJobBytes(bytes));
  const std::uint64_t more = bytes - reservation->bytes_;
  const std::lock_guard lock(mutex_);
  LIMN_RETURN_IF_ERROR(CheckTotal(more));
  reserved_ += more;
  reservation->admission_ = this;
  reservation->bytes_ = bytes;
  return absl::OkStatus();
}

absl::Status Admission::CheckJobBytes(std::uint64_t bytes, bool level_chosen) const {
  // Of the total no other job has to give anything back for this: trying again would not help.
  const bool job = limits_.max_job_bytes <= limits_.max_total_bytes;
  const std::uint64_t limit = job ? limits_.max_job_bytes : limits_.max_total_bytes;
  if (bytes <= limit) return absl::OkStatus();
  return TooLarge(
      level_chosen ? "surface.chord_tolerance" : "surface.level",
      absl::StrCat("the job may need ", ByteText(bytes), " of memory, more than ", ByteText(limit)),
      job ? "max-job-bytes" : "max-total-bytes",
      level_chosen ? "Not even level 0 fits: use a smaller mesh"
                   : "Ask for a lower level or use a smaller mesh");
}

absl::Status Admission::CheckTotal(std::uint64_t more) const {
  if (reserved_ <= limits_.max_total_bytes && more <= limits_.max_total_bytes - reserved_) {
    return absl::OkStatus();
  }
  return Busy(
      absl::StrCat("its jobs need ", ByteText(reserved_), " of memory, this one ", ByteText(more),
                   " more, together more than ", ByteText(limits_.max_total_bytes)),
      "max-total-bytes");
}

std::uint64_t Admission::reserved_bytes() const {
  const std::lock_guard lock(mutex_);
  return reserved_;
}

}  // namespace limn
