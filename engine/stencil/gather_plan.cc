// SPDX-License-Identifier: MIT
#include "engine/stencil/gather_plan.h"

namespace limn {
namespace {

// Rows per block: their points and sums stay in the second-level cache.
constexpr std::size_t kBlock = 2048;
// Longer rows get a run of their own: sorting them by length gains nothing.
constexpr std::size_t kLongest = 16;

}  // namespace

absl::StatusOr<GatherPlan> GatherPlan::Make(const Context& context, absl::Span<const Index> offsets,
                                            absl::Span<const std::uint16_t> kinds,
                                            std::size_t kind_count) {
  const std::size_t rows = offsets.size() - 1;
  const std::size_t blocks = (rows + kBlock - 1) / kBlock;
  GatherPlan plan;
  plan.slot_of_row_.resize(rows);
  plan.row_of_slot_.resize(rows);
  std::vector<std::vector<Run>> block_runs(blocks);
  const auto kind_of = [&](std::size_t row) {
    return kinds.empty() ? std::uint16_t{0} : kinds[row];
  };
  // A counting sort by (kind, length) inside each block.
  const std::size_t keys = kind_count * (kLongest + 1);
  LIMN_RETURN_IF_ERROR(ParallelBlocks(
      context, rows, kBlock, [&](std::size_t block, std::size_t begin, std::size_t end) {
        const auto key_of = [&](std::size_t row) {
          const std::size_t length = offsets[row + 1] - offsets[row];
          return kind_of(row) * (kLongest + 1) + std::min(length, kLongest);
        };
        std::vector<Index> next(keys + 1, 0);
        for (std::size_t row = begin; row < end; ++row) ++next[key_of(row) + 1];
        for (std::size_t key = 0; key < keys; ++key) next[key + 1] += next[key];
        for (std::size_t row = begin; row < end; ++row) {
          const Index slot = static_cast<Index>(begin + next[key_of(row)]++);
          plan.slot_of_row_[row] = slot;
          plan.row_of_slot_[slot] = static_cast<Index>(row);
        }
        std::vector<Run>& runs = block_runs[block];
        Index item = offsets[begin];
        for (std::size_t slot = begin; slot < end; ++slot) {
          const Index row = plan.row_of_slot_[slot];
          const Index length = offsets[row + 1] - offsets[row];
          if (runs.empty() || runs.back().length != length || runs.back().kind != kind_of(row)) {
            runs.push_back({.begin = static_cast<Index>(slot),
                            .end = static_cast<Index>(slot),
                            .item = item,
                            .length = length,
                            .kind = kind_of(row)});
          }
          runs.back().end = static_cast<Index>(slot + 1);
          item += length;
        }
      }));
  plan.block_run_.push_back(0);
  for (const std::vector<Run>& runs : block_runs) {
    plan.runs_.insert(plan.runs_.end(), runs.begin(), runs.end());
    plan.block_run_.push_back(static_cast<Index>(plan.runs_.size()));
  }
  return plan;
}

}  // namespace limn
