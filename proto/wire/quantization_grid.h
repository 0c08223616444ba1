// SPDX-License-Identifier: MIT
// The grid that positions are rounded to by MESH_ENCODING_DRACO_QUANTIZED.
#pragma once

#include <array>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"

namespace limn::wire {

// Quantisation bits per coordinate that are taken. Positions are float32, so bits above
// kUsefulQuantizationBits are taken as that many; more would only cost memory (Draco's encoder
// counts symbols in a table of 2^bits numbers).
inline constexpr int kMinQuantizationBits = 8;
inline constexpr int kMaxQuantizationBits = 30;
inline constexpr int kUsefulQuantizationBits = 24;

// The grid on which positions are rounded: cubes of edge range / (2^bits - 1), the first corner at
// `origin`. In float32, as Draco computes.
struct QuantizationGrid {
  std::array<float, 3> origin = {0, 0, 0};
  float range = 1;
  // Whether normals are quantised too (octahedral, kNormalBits). Not where some are (0, 0, 0),
  // which the octahedron cannot say.
  bool quantize_normals = true;

  friend bool operator==(const QuantizationGrid&, const QuantizationGrid&) = default;
};

// Bits per octahedral coordinate of a quantised normal: angles are kept to about 0.01 degrees.
inline constexpr int kNormalBits = 14;

// The grid of a surface: its bounding box, the same along all axes. Errors: NON_FINITE_COORDINATE,
// COORDINATE_TOO_LARGE (beyond float32), with field "positions" and the vertex; CANCELLED,
// DEADLINE_EXCEEDED. The same bits for any number of threads. Cost: linear, in parallel.
[[nodiscard]] absl::StatusOr<QuantizationGrid> FitGrid(const Context& context,
                                                       absl::Span<const Vec3> positions,
                                                       absl::Span<const Vec3> normals);

}  // namespace limn::wire
