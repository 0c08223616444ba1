// SPDX-License-Identifier: MIT
// Parameters and samples of a surface <-> messages of the rpc Evaluate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "engine/base/vec3.h"
#include "engine/limit/evaluate.h"
#include "limn/v1/evaluate.pb.h"

namespace limn::wire {

// Parameters of a block at the most.
inline constexpr std::size_t kMaxBlockParameters = std::size_t{1} << 16;
// Bytes of a sample's four vectors.
inline constexpr std::size_t kSampleBytes = 4 * sizeof(Vec3);

// Whether the block's arrays fit together and are not too long. Errors: MALFORMED_REQUEST, naming
// the array. The parameters themselves are not looked at. Cost: constant. Thread-safe.
[[nodiscard]] absl::Status CheckParameters(const v1::ParameterBlock& block);
// The same for any length.
[[nodiscard]] absl::Status CheckParameterArrays(const v1::ParameterBlock& block);

// Parameters begin .. begin + count - 1 of a checked block.
[[nodiscard]] std::vector<SurfaceParameter> ReadParameters(const v1::ParameterBlock& block,
                                                           std::size_t begin, std::size_t count);

// Replaces the block's arrays.
void WriteParameters(absl::Span<const SurfaceParameter> parameters, v1::ParameterBlock* block);

// Samples of n parameters, as arrays of their own.
struct SampleArrays {
  std::vector<Vec3> points;
  std::vector<Vec3> du;
  std::vector<Vec3> dv;
  std::vector<Vec3> normals;

  void Resize(std::size_t n);
  SurfaceSamples Spans();
};

// first: the number of the first parameter.
void EncodeSamples(const SampleArrays& samples, std::uint64_t first, v1::EvaluateResponse* message);

// Appends a message's samples. Errors: MALFORMED_ENCODING when its arrays do not fit together or do
// not follow those before. Thread-safe.
[[nodiscard]] absl::Status DecodeSamples(const v1::EvaluateResponse& message,
                                         SampleArrays* samples);

}  // namespace limn::wire
