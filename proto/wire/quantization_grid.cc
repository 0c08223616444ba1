// SPDX-License-Identifier: MIT
// See quantization_grid.h.
#include "proto/wire/quantization_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn::wire {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Below this extent, steps of the finest grid would be denormal.
constexpr float kSmallestRange = 0x1p-96F;

struct Box {
  std::array<float, 3> low = {kInfinity, kInfinity, kInfinity};
  std::array<float, 3> high = {-kInfinity, -kInfinity, -kInfinity};
  bool finite = true;

  void Add(const Vec3& p) {
    const std::array<double, 3> point = {p.x, p.y, p.z};
    for (int c = 0; c < 3; ++c) {
      const float x = static_cast<float>(point[c]);
      finite = finite && std::isfinite(x);
      low[c] = std::min(low[c], x);
      high[c] = std::max(high[c], x);
    }
  }
  void Add(const Box& box) {
    for (int c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], box.low[c]);
      high[c] = std::max(high[c], box.high[c]);
    }
    finite = finite && box.finite;
  }
};

absl::Status NotFinite(absl::Span<const Vec3> positions) {
  std::size_t v = 0;
  while (v + 1 < positions.size() && IsFinite(positions[v]) &&
         MaxAbs(positions[v]) <= std::numeric_limits<float>::max()) {
    ++v;
  }
  const bool finite = IsFinite(positions[v]);
  return MakeError(
      absl::StrCat("vertex ", v, " has a coordinate that is ", finite ? "too large" : "not finite"),
      {.reason = finite ? Reason::kCoordinateTooLarge : Reason::kNonFiniteCoordinate,
       .field = "positions",
       .index = v,
       .remedy = "Quantised encoding needs finite coordinates within float32"});
}

absl::StatusOr<bool> AllNonZero(const Context& context, absl::Span<const Vec3> normals) {
  double zero = 0;
  LIMN_RETURN_IF_ERROR(ParallelMax(
      context, normals.size(), 0,
      [&](std::size_t begin, std::size_t end) {
        double found = 0;
        // Negated, so that NaN counts as zero.
        for (std::size_t i = begin; i < end; ++i) found = MaxAbs(normals[i]) > 0 ? found : 1;
        return found;
      },
      &zero));
  return zero == 0;
}

}  // namespace

absl::StatusOr<QuantizationGrid> FitGrid(const Context& context, absl::Span<const Vec3> positions,
                                         absl::Span<const Vec3> normals) {
  std::vector<Box> boxes((positions.size() + kScanBlock - 1) / kScanBlock);
  LIMN_RETURN_IF_ERROR(ParallelBlocks(context, positions.size(), kScanBlock,
                                      [&](std::size_t block, std::size_t begin, std::size_t end) {
                                        for (std::size_t v = begin; v < end; ++v)
                                          boxes[block].Add(positions[v]);
                                      }));
  Box box;
  for (const Box& part : boxes) box.Add(part);
  if (!box.finite) return NotFinite(positions);
  QuantizationGrid grid;
  LIMN_ASSIGN_OR_RETURN(grid.quantize_normals, AllNonZero(context, normals));
  if (positions.empty()) return grid;
  grid.origin = box.low;
  grid.range = kSmallestRange;
  for (int c = 0; c < 3; ++c) grid.range = std::max(grid.range, box.high[c] - box.low[c]);
  if (!std::isfinite(grid.range)) {
    return MakeError("the bounding box is larger than float32 can say",
                     {.reason = Reason::kCoordinateTooLarge,
                      .field = "positions",
                      .remedy = "Use MESH_ENCODING_PACKED or MESH_ENCODING_DRACO"});
  }
  return grid;
}

}  // namespace limn::wire
