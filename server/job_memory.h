// SPDX-License-Identifier: MIT
// The memory that a job takes: what admission sets aside for it.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "server/options_from_proto.h"

namespace limn {

// Bytes that a job holds at its peak, by the counts of its mesh: the most of decoding, repair,
// computing, encoding the control mesh and sending the answer, with all that is kept from one to
// the next, constraints, certificate, messages that wait, and parameters to evaluate. With repair
// it reckons with the worst mesh of that size. An upper bound for what is allocated, for open
// meshes of genus 0 and for closed ones. Saturates.
//
// Counts that a Draco header does not claim count as 0; see EstimateDecodeBytes.
[[nodiscard]] std::uint64_t EstimateJobBytes(const JobSpec& spec);

// For a job to a chord tolerance, whose level is not known yet: the finest level that it may choose
// becomes the largest one for which EstimateJobBytes is within the limits' max_bytes, so that what
// is set aside for the job is enough whatever it chooses. Nothing else changes.
void FitFinestLevel(const Limits& limits, JobSpec* spec);

// Bytes that a job holds while its mesh is uploaded.
[[nodiscard]] std::uint64_t EstimateUploadBytes(const JobSpec& spec);

// Bytes that a job holds until its mesh is decoded, by what the encoded mesh says of itself, which
// its length has to justify; see draco_header.h. Errors: MALFORMED_ENCODING.
[[nodiscard]] absl::StatusOr<std::uint64_t> EstimateDecodeBytes(const JobSpec& spec,
                                                                std::string_view encoded_mesh);

}  // namespace limn
