// SPDX-License-Identifier: MIT
// Rows of indices of different lengths (the corners of faces, the faces around vertices), reordered
// so that sums over rows run without mispredicted branches: inside blocks of some thousand rows,
// rows of equal length stand together and are summed by loops of constant length. Rows keep their
// block, so locality stays that of the input.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

class GatherPlan {
 public:
  // Rows with the same length and kind, in slots [begin, end); their indices start at `item` and
  // stand `length` apart.
  struct Run {
    Index begin;
    Index end;
    Index item;
    Index length;
    std::uint16_t kind;
  };

  // Row r has length offsets[r + 1] - offsets[r] and kind kinds[r], below kind_count (kinds empty:
  // all 0). Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one pass over rows.
  [[nodiscard]] static absl::StatusOr<GatherPlan> Make(const Context& context,
                                                       absl::Span<const Index> offsets,
                                                       absl::Span<const std::uint16_t> kinds,
                                                       std::size_t kind_count);

  std::size_t size() const { return row_of_slot_.size(); }
  // The place of each row in the new order, and back.
  absl::Span<const Index> slot_of_row() const { return slot_of_row_; }
  absl::Span<const Index> row_of_slot() const { return row_of_slot_; }

  // Sets the indices: index(offsets[r] + j) is what entry j of row r refers to.
  template <class IndexOf>
  [[nodiscard]] absl::Status Fill(const Context& context, absl::Span<const Index> offsets,
                                  const IndexOf& index) {
    items_.resize(offsets.back());
    return ForEachRun(context, [&](const Run& run) {
      Index* item = items_.data() + run.item;
      for (Index slot = run.begin; slot < run.end; ++slot, item += run.length) {
        const Index first = offsets[row_of_slot_[slot]];
        for (Index j = 0; j < run.length; ++j) item[j] = index(first + j);
      }
    });
  }

  // The indices of a run's slots, run.length for each.
  const Index* items(const Run& run) const { return items_.data() + run.item; }

  // Calls f(run) for every run, blocks in parallel.
  template <class F>
  [[nodiscard]] absl::Status ForEachRun(const Context& context, const F& f) const {
    return ParallelFor(context, block_run_.size() - 1, 1, [&](std::size_t begin, std::size_t end) {
      for (Index r = block_run_[begin]; r < block_run_[end]; ++r) f(runs_[r]);
    });
  }

  // Calls visitor(slot, sum of in[] over the slot's indices) for all slots of a run.
  template <class Visitor>
  void VisitSums(const Run& run, const Vec3* in, const Visitor& visitor) const {
    switch (run.length) {
      case 3:
        return SumRun<3>(run, in, visitor);
      case 4:
        return SumRun<4>(run, in, visitor);
      case 5:
        return SumRun<5>(run, in, visitor);
      case 6:
        return SumRun<6>(run, in, visitor);
      case 7:
        return SumRun<7>(run, in, visitor);
      case 8:
        return SumRun<8>(run, in, visitor);
      default:
        return SumRun<0>(run, in, visitor);
    }
  }

  // Largest value of f(run) over all runs, and at least 0.
  template <class F>
  [[nodiscard]] absl::Status MaxOverRuns(const Context& context, const F& f,
                                         double* largest) const {
    std::vector<double> most(block_run_.size() - 1, 0);
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context, most.size(), 1, [&](std::size_t begin, std::size_t end) {
          for (std::size_t block = begin; block < end; ++block) {
            for (Index r = block_run_[block]; r < block_run_[block + 1]; ++r) {
              most[block] = std::max(most[block], f(runs_[r]));
            }
          }
        }));
    *largest = *std::max_element(most.begin(), most.end());
    return absl::OkStatus();
  }

 private:
  // kLength 0: the run's own. Sums in the order of the row's entries.
  template <Index kLength, class Visitor>
  void SumRun(const Run& run, const Vec3* in, const Visitor& visitor) const {
    const Index length = kLength == 0 ? run.length : kLength;
    const Index* item = items_.data() + run.item;
    for (Index slot = run.begin; slot < run.end; ++slot, item += length) {
      Vec3 sum = in[item[0]];
      for (Index j = 1; j < length; ++j) sum += in[item[j]];
      visitor(slot, sum);
    }
  }

  Buffer<Index> slot_of_row_;
  Buffer<Index> row_of_slot_;
  Buffer<Index> items_;
  std::vector<Run> runs_;
  // First run of each block, and at the end their number.
  std::vector<Index> block_run_;
};

}  // namespace limn
