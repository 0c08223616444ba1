// SPDX-License-Identifier: MIT
#include "engine/mesh/edge_numbering.h"

#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {

absl::Status NumberEdges(const Context& context, absl::Span<const Index> twin,
                         std::size_t edge_bound, Buffer<Index>* edge,
                         Buffer<Index>* edge_half_edge) {
  edge->resize(twin.size());
  edge_half_edge->resize(edge_bound);
  Index* const edges_out = edge->data();
  Index* const first_out = edge_half_edge->data();
  const Index* const twins = twin.data();
  std::uint64_t edges = 0;
  // Pointers are copied into the loops: looking them up again at each step takes a third of it.
  LIMN_RETURN_IF_ERROR(ParallelNumber(
      context, twin.size(),
      [=](std::size_t begin, std::size_t end) {
        std::uint64_t count = 0;
        // kNoIndex is larger than any half-edge: boundary half-edges count.
        for (std::size_t h = begin; h < end; ++h) count += h < twins[h] ? 1 : 0;
        return count;
      },
      [=](std::size_t begin, std::size_t end, std::uint64_t first) {
        Index e = static_cast<Index>(first);
        for (std::size_t h = begin; h < end; ++h) {
          const Index other = twins[h];
          if (h >= other) continue;
          edges_out[h] = e;
          first_out[e] = static_cast<Index>(h);
          // Written by the one block that owns the edge's first half-edge.
          if (other != kNoIndex) edges_out[other] = e;
          ++e;
        }
      },
      &edges));
  edge_half_edge->resize(edges);
  return absl::OkStatus();
}

}  // namespace limn
