// SPDX-License-Identifier: MIT
#include "server/admission.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "engine/base/error.h"
#include "engine/limit/certificate.h"
#include "engine/mesh/repair.h"
#include "proto/wire/samples.h"
#include "proto/wire/status.h"
#include "server/constraints_from_proto.h"

namespace limn {
namespace {

// Two encoded tiles wait, one is written, one is made; a chunk arrives.
constexpr std::uint64_t kMessagesInFlight = 5;
// One block of parameters is answered, one waits, one arrives.
constexpr std::uint64_t kBlocksInFlight = 3;
// What LargeFaces may keep for each corner.
constexpr std::uint64_t kLargeFaceBytes = 12;

std::uint64_t SaturatingAdd(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t sum = a + b;
  return sum < a ? std::numeric_limits<std::uint64_t>::max() : sum;
}

absl::Status TooLarge(absl::string_view field, absl::string_view message, absl::string_view limit,
                      absl::string_view remedy) {
  return MakeError(absl::StrCat(field, ": ", message, " (limit ", limit, ")"),
                   {.reason = Reason::kLimitExceeded,
                    .field = std::string(field),
                    .remedy = std::string(remedy),
                    .limit = std::string(limit)});
}

}  // namespace

std::uint64_t EstimateJobBytes(const JobSpec& spec) {
  // The claims are held against limits below 2^33 before this is called, so products fit.
  std::uint64_t vertices = spec.mesh.vertex_count();
  std::uint64_t faces = spec.mesh.face_count();
  const std::uint64_t corners = spec.mesh.corner_count();
  const auto decoded_bytes = [&] {
    return vertices * sizeof(Vec3) + (faces + 1 + corners) * sizeof(Index);
  };
  std::uint64_t decoded = decoded_bytes();
  std::uint64_t repair = 0;
  if (spec.repair) {
    repair = SaturatingAdd(decoded, EstimateRepairBytes(vertices, faces, corners));
    // What may come of it; every corner may get a vertex of its own, and faces fall into triangles.
    vertices = std::max(vertices, corners);
    faces = std::max(faces, corners / 3);
    decoded = decoded_bytes() + (vertices + faces) * sizeof(Index);
  }
  const std::uint64_t engine =
      SaturatingAdd(decoded, EstimateBytes(vertices, faces, corners, spec.engine));
  std::uint64_t bytes = SaturatingAdd(spec.mesh.byte_count(), std::max(repair, engine));
  if (spec.send_control_mesh) bytes = SaturatingAdd(bytes, decoded);
  const Constraints& constraints = spec.engine.constraints;
  bytes = SaturatingAdd(bytes, CertificateBuilder::Bytes(vertices, constraints.normals.size()));
  // The call keeps its copy, and the job has one.
  bytes = SaturatingAdd(bytes, 2 * ConstraintBytes(constraints));
  if (spec.engine.keep_patches) {
    bytes = SaturatingAdd(bytes, kLargeFaceBytes * corners + kBlocksInFlight *
                                                                 wire::kMaxBlockParameters *
                                                                 sizeof(SurfaceParameter));
  }
  return SaturatingAdd(bytes, kMessagesInFlight * spec.tiles.tile_bytes);
}

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
  admission->reserved_ -= bytes_;
}

absl::StatusOr<Admission::Ticket> Admission::Admit(const JobSpec& spec) {
  LIMN_RETURN_IF_ERROR(
      wire::CheckHeader(EngineLimits(limits_), spec.mesh, {.any_arity = spec.repair}));
  if (spec.mesh.byte_count() > limits_.max_mesh_bytes) {
    return TooLarge(
        "mesh.byte_count",
        absl::StrCat(spec.mesh.byte_count(), " bytes are more than ", limits_.max_mesh_bytes),
        "max-mesh-bytes", "Use a smaller mesh or a smaller encoding");
  }
  if (spec.engine.level > limits_.max_level) {
    return TooLarge("surface.level",
                    absl::StrCat(spec.engine.level, " is above ", limits_.max_level), "max-level",
                    "Ask for a lower level");
  }
  const std::uint64_t bytes = EstimateJobBytes(spec);
  if (bytes > limits_.max_job_bytes) {
    return TooLarge("surface.level",
                    absl::StrCat("the job may need ", bytes, " bytes of memory, more than ",
                                 limits_.max_job_bytes),
                    "max-job-bytes", "Ask for a lower level or use a smaller mesh");
  }
  if (bytes > limits_.max_total_bytes) {
    // No other job has to end for this: trying again would not help.
    return TooLarge("surface.level",
                    absl::StrCat("the job may need ", bytes, " bytes of memory, more than ",
                                 limits_.max_total_bytes),
                    "max-total-bytes", "Ask for a lower level or use a smaller mesh");
  }
  Ticket ticket;
  LIMN_ASSIGN_OR_RETURN(ticket.place, lane_.Reserve());
  LIMN_ASSIGN_OR_RETURN(ticket.memory, Reserve(bytes));
  return ticket;
}

absl::StatusOr<Admission::Reservation> Admission::Reserve(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  if (reserved_ > limits_.max_total_bytes - bytes) {
    return MakeError(absl::StrCat("the server is busy: its jobs need ", reserved_,
                                  " bytes of memory, this one ", bytes, ", together more than ",
                                  limits_.max_total_bytes, " (limit max-total-bytes)"),
                     {.reason = Reason::kLimitExceeded,
                      .field = std::string(wire::kQueueField),
                      .remedy = "Try again a little later",
                      .limit = "max-total-bytes"});
  }
  reserved_ += bytes;
  return Reservation(this, bytes);
}

std::uint64_t Admission::reserved_bytes() const {
  const std::lock_guard lock(mutex_);
  return reserved_;
}

}  // namespace limn
