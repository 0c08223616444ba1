// SPDX-License-Identifier: MIT
#include "engine/mesh/edge_numbering.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// Half-edges whose numbers of edges are found at a time.
constexpr std::size_t kBatch = 512;

// Numbers the first half-edges of [begin, end) from e on: edge of each, and half-edge of each edge.
// Which half-edges are first is as good as random, so that nothing branches on it: others get a
// number too, which is overwritten later, as is what they leave in the list.
void NumberFirst(const Index* twins, std::size_t begin, std::size_t end, Index e, Index* edges,
                 Index* first) {
  std::array<Index, kBatch + 1> found;
  while (begin < end) {
    const std::size_t stop = std::min(end, begin + kBatch);
    std::size_t count = 0;
    for (std::size_t h = begin; h < stop; ++h) {
      edges[h] = e + static_cast<Index>(count);
      found[count] = static_cast<Index>(h);
      // kNoIndex is larger than any half-edge: boundary half-edges count.
      count += h < twins[h] ? 1 : 0;
    }
    std::copy_n(found.data(), count, first + e);
    e += static_cast<Index>(count);
    begin = stop;
  }
}

}  // namespace

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
        for (std::size_t h = begin; h < end; ++h) count += h < twins[h] ? 1 : 0;
        return count;
      },
      [=](std::size_t begin, std::size_t end, std::uint64_t first) {
        NumberFirst(twins, begin, end, static_cast<Index>(first), edges_out, first_out);
      },
      &edges));
  edge_half_edge->resize(edges);
  return ParallelFor(context, edges, [=](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const Index other = twins[first_out[e]];
      if (other != kNoIndex) edges_out[other] = static_cast<Index>(e);
    }
  });
}

}  // namespace limn
