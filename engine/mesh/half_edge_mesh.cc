// SPDX-License-Identifier: MIT
#include "engine/mesh/half_edge_mesh.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/edge_numbering.h"
#include "engine/mesh/validate.h"

namespace limn {
namespace {

// Buckets above this size are sorted by end vertex and searched by halving.
constexpr std::size_t kLargeBucket = 32;

}  // namespace

// The phases of HalfEdgeMesh::Build. Each fills arrays of `mesh_` that it alone writes.
class HalfEdgeMeshBuilder {
 public:
  HalfEdgeMeshBuilder(const Context& context, const PolygonMesh& input)
      : context_(context), input_(input) {}

  absl::StatusOr<HalfEdgeMesh> Build() {
    LIMN_RETURN_IF_ERROR(ValidateFaces(context_, input_));
    LIMN_RETURN_IF_ERROR(CopyFaces());
    LIMN_RETURN_IF_ERROR(FillBuckets());
    LIMN_RETURN_IF_ERROR(PairTwins());
    LIMN_RETURN_IF_ERROR(OrderFans());
    LIMN_RETURN_IF_ERROR(NumberEdges(context_, mesh_.twin_, input_.corner_count(), &mesh_.edge_,
                                     &mesh_.edge_half_edge_));
    return std::move(mesh_);
  }

 private:
  absl::Status CopyFaces() {
    const std::size_t corners = input_.corner_count();
    mesh_.vertex_.resize(corners);
    mesh_.face_.resize(corners);
    mesh_.face_begin_ = input_.face_begin;
    return ParallelFor(context_, input_.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        for (Index h = mesh_.face_begin_[f]; h < mesh_.face_begin_[f + 1]; ++h) {
          mesh_.face_[h] = static_cast<Index>(f);
          mesh_.vertex_[h] = input_.corner_vertex[h];
        }
      }
    });
  }

  // Buckets of outgoing half-edges per vertex, in half-edge order. Each range of vertices has one
  // owner who looks at all corners: no atomics, and the order does not depend on the threads.
  absl::Status FillBuckets() {
    const std::size_t vertices = input_.vertex_count();
    const std::size_t corners = input_.corner_count();
    constexpr int kMostRanges = 8;
    const std::size_t ranges = std::clamp(tbb::this_task_arena::max_concurrency(), 1, kMostRanges);
    const auto range_of = [&](std::size_t i) { return vertices * i / ranges; };
    mesh_.fan_begin_.assign(vertices + 1, 0);
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, ranges, 1, [&](std::size_t first, std::size_t last) {
      const std::size_t lo = range_of(first);
      const std::size_t size = range_of(last) - lo;
      for (std::size_t h = 0; h < corners; ++h) {
        const std::size_t at = std::size_t{mesh_.vertex_[h]} - lo;
        if (at < size) ++mesh_.fan_begin_[lo + at];
      }
    }));
    LIMN_RETURN_IF_ERROR(ParallelExclusiveSum(context_, absl::MakeSpan(mesh_.fan_begin_)));
    mesh_.fan_.resize(corners);
    bucket_end_.resize(corners);
    Buffer<Index> cursor(mesh_.fan_begin_);
    return ParallelFor(context_, ranges, 1, [&](std::size_t first, std::size_t last) {
      const std::size_t lo = range_of(first);
      const std::size_t size = range_of(last) - lo;
      for (std::size_t f = 0; f < input_.face_count(); ++f) {
        const Index face_begin = mesh_.face_begin_[f];
        const Index face_end = mesh_.face_begin_[f + 1];
        for (Index h = face_begin; h < face_end; ++h) {
          const std::size_t at = std::size_t{mesh_.vertex_[h]} - lo;
          if (at >= size) continue;
          const Index slot = cursor[lo + at]++;
          mesh_.fan_[slot] = h;
          bucket_end_[slot] = mesh_.vertex_[h + 1 == face_end ? face_begin : h + 1];
        }
      }
    });
  }

  void SortLargeBucket(std::size_t v) {
    const Index begin = mesh_.fan_begin_[v];
    const Index end = mesh_.fan_begin_[v + 1];
    if (end - begin <= kLargeBucket) return;
    std::vector<std::pair<Index, Index>> pairs(end - begin);
    for (Index i = begin; i < end; ++i) pairs[i - begin] = {bucket_end_[i], mesh_.fan_[i]};
    std::sort(pairs.begin(), pairs.end());
    for (Index i = begin; i < end; ++i) {
      std::tie(bucket_end_[i], mesh_.fan_[i]) = pairs[i - begin];
    }
  }

  // Number of half-edges from v to `end`; *found is one of them.
  std::size_t CountOutgoing(Index v, Index end, Index* found) const {
    const Index first = mesh_.fan_begin_[v];
    const Index last = mesh_.fan_begin_[v + 1];
    std::size_t count = 0;
    if (last - first <= kLargeBucket) {
      for (Index i = first; i < last; ++i) {
        if (bucket_end_[i] == end) {
          *found = mesh_.fan_[i];
          ++count;
        }
      }
      return count;
    }
    const auto [lo, hi] =
        std::equal_range(bucket_end_.begin() + first, bucket_end_.begin() + last, end);
    if (lo != hi) *found = mesh_.fan_[static_cast<std::size_t>(lo - bucket_end_.begin())];
    return static_cast<std::size_t>(hi - lo);
  }

  // The end of smaller number pairs an edge's half-edges and writes both.
  absl::Status PairTwins() {
    const std::size_t vertices = input_.vertex_count();
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, vertices, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) SortLargeBucket(v);
    }));
    mesh_.twin_.assign(input_.corner_count(), kNoIndex);
    std::atomic<bool> malformed{false};
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, vertices, [&](std::size_t begin, std::size_t end) {
      bool bad = false;
      for (std::size_t v = begin; v < end; ++v) bad |= !PairAt(static_cast<Index>(v));
      if (bad) malformed.store(true, std::memory_order_relaxed);
    }));
    if (!malformed.load()) {
      LIMN_RETURN_IF_ERROR(ParallelFor(context_, vertices, [&](std::size_t begin, std::size_t end) {
        bool bad = false;
        for (std::size_t v = begin; v < end; ++v) bad |= !BoundaryIsSimple(static_cast<Index>(v));
        if (bad) malformed.store(true, std::memory_order_relaxed);
      }));
    }
    if (!malformed.load()) return absl::OkStatus();
    LIMN_RETURN_IF_ERROR(DiagnoseEdges(input_));
    return MakeError("half-edges do not pair up", {.reason = Reason::kInternal});
  }

  // False when an edge from v to a larger vertex has more than one half-edge in a direction.
  bool PairAt(Index v) {
    for (Index i = mesh_.fan_begin_[v]; i < mesh_.fan_begin_[v + 1]; ++i) {
      const Index end = bucket_end_[i];
      if (end < v) continue;
      Index other = kNoIndex;
      const std::size_t count = CountOutgoing(end, v, &other);
      if (count == 0) continue;
      // An edge walked twice from v finds its partner taken.
      if (count > 1 || mesh_.twin_[other] != kNoIndex) return false;
      mesh_.twin_[mesh_.fan_[i]] = other;
      mesh_.twin_[other] = mesh_.fan_[i];
    }
    return true;
  }

  // False when two half-edges without twin run from v to the same end.
  bool BoundaryIsSimple(Index v) const {
    for (Index i = mesh_.fan_begin_[v]; i < mesh_.fan_begin_[v + 1]; ++i) {
      if (mesh_.twin_[mesh_.fan_[i]] != kNoIndex) continue;
      Index found = kNoIndex;
      if (CountOutgoing(v, bucket_end_[i], &found) > 1) return false;
    }
    return true;
  }

  // Turns each bucket into a counter-clockwise fan that starts at the boundary if there is one.
  absl::Status OrderFans() {
    const std::size_t vertices = input_.vertex_count();
    mesh_.vertex_half_edge_.resize(vertices);
    std::vector<Findings> blocks((vertices + kScanBlock - 1) / kScanBlock);
    LIMN_RETURN_IF_ERROR(ParallelBlocks(context_, vertices, kScanBlock,
                                        [&](std::size_t block, std::size_t begin, std::size_t end) {
                                          for (std::size_t v = begin; v < end; ++v)
                                            OrderFan(v, &blocks[block]);
                                        }));
    Findings all;
    for (const Findings& block : blocks) {
      all.isolated += block.isolated;
      all.multiple += block.multiple;
      all.first_isolated = std::min(all.first_isolated, block.first_isolated);
      all.first_multiple = std::min(all.first_multiple, block.first_multiple);
    }
    bucket_end_ = {};
    return Report(all);
  }

  struct Findings {
    std::uint64_t isolated = 0;
    std::uint64_t multiple = 0;
    std::uint64_t first_isolated = std::numeric_limits<std::uint64_t>::max();
    std::uint64_t first_multiple = std::numeric_limits<std::uint64_t>::max();
  };

  static absl::Status Report(const Findings& found) {
    if (found.multiple > 0) {
      return MakeError(
          absl::StrCat("non-manifold vertices (faces that do not form one fan): ", found.multiple,
                       " vertices, first vertex ", found.first_multiple),
          {.reason = Reason::kNonManifoldVertex,
           .field = "mesh.vertices",
           .index = found.first_multiple,
           .remedy = "Give each fan a vertex of its own"});
    }
    if (found.isolated > 0) {
      return MakeError(absl::StrCat("isolated vertices (used by no face): ", found.isolated,
                                    " vertices, first vertex ", found.first_isolated),
                       {.reason = Reason::kIsolatedVertex,
                        .field = "mesh.vertices",
                        .index = found.first_isolated,
                        .remedy = "Remove them"});
    }
    return absl::OkStatus();
  }

  void OrderFan(std::size_t v, Findings* findings) {
    const Index begin = mesh_.fan_begin_[v];
    const Index end = mesh_.fan_begin_[v + 1];
    if (begin == end) {
      ++findings->isolated;
      findings->first_isolated = std::min<std::uint64_t>(findings->first_isolated, v);
      mesh_.vertex_half_edge_[v] = kNoIndex;
      return;
    }
    Index start = mesh_.fan_[begin];
    for (Index i = begin; i < end; ++i) {
      const Index h = mesh_.fan_[i];
      if (mesh_.twin_[h] == kNoIndex) {
        start = h;
        break;
      }
      start = std::min(start, h);
    }
    mesh_.vertex_half_edge_[v] = start;
    const PolygonWalk walk(mesh_);
    Index at = begin;
    Index h = start;
    do {
      mesh_.fan_[at++] = h;
      h = mesh_.twin_[walk.Prev(h)];
    } while (h != kNoIndex && h != start && at < end);
    const bool closed_or_boundary = h == kNoIndex || h == start;
    if (at != end || !closed_or_boundary) {
      ++findings->multiple;
      findings->first_multiple = std::min<std::uint64_t>(findings->first_multiple, v);
    }
  }

  const Context& context_;
  const PolygonMesh& input_;
  HalfEdgeMesh mesh_;
  // End vertex of each half-edge in the buckets.
  Buffer<Index> bucket_end_;
};

absl::StatusOr<HalfEdgeMesh> HalfEdgeMesh::Build(const Context& context, const PolygonMesh& mesh) {
  return HalfEdgeMeshBuilder(context, mesh).Build();
}

}  // namespace limn
