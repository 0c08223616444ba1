// SPDX-License-Identifier: MIT
#include "engine/mesh/half_edge_mesh.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/edge_numbering.h"
#include "engine/mesh/validate.h"

namespace limn {
namespace {

// Buckets above this size are sorted before their half-edges are paired.
constexpr std::size_t kLargeBucket = 32;

// What the walk around vertices found.
struct FanFindings {
  std::uint64_t isolated = 0;
  std::uint64_t multiple = 0;
  std::uint64_t first_isolated = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t first_multiple = std::numeric_limits<std::uint64_t>::max();

  void Add(const FanFindings& other) {
    isolated += other.isolated;
    multiple += other.multiple;
    first_isolated = std::min(first_isolated, other.first_isolated);
    first_multiple = std::min(first_multiple, other.first_multiple);
  }
};

absl::Status ReportFans(const FanFindings& found) {
  if (found.multiple > 0) {
    return MakeError(absl::StrCat("non-manifold vertices (faces that do not form one fan): ",
                                  found.multiple, " vertices, first vertex ", found.first_multiple),
                     {.reason = Reason::kNonManifoldVertex,
                      .field = "mesh.vertices",
                      .index = found.first_multiple,
                      .remedy = OrRepair("Give each fan a vertex of its own")});
  }
  if (found.isolated > 0) {
    return MakeError(absl::StrCat("isolated vertices (used by no face): ", found.isolated,
                                  " vertices, first vertex ", found.first_isolated),
                     {.reason = Reason::kIsolatedVertex,
                      .field = "mesh.vertices",
                      .index = found.first_isolated,
                      .remedy = OrRepair("Remove them")});
  }
  return absl::OkStatus();
}

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
    mesh_.vertex_ = input_.corner_vertex;
    mesh_.face_begin_ = input_.face_begin;
    mesh_.face_.resize(corners);
    const Index* const first = mesh_.face_begin_.data();
    Index* const face = mesh_.face_.data();
    return ParallelFor(context_, input_.face_count(), [=](std::size_t begin, std::size_t end) {
      // Arities are as good as random. Four at a time, and what is written too much is overwritten
      // by the faces that follow, but not beyond the range.
      constexpr Index kStep = 4;
      const Index safe = first[end] - std::min(first[end], kStep - 1);
      for (std::size_t f = begin; f < end; ++f) {
        const Index stop = first[f + 1];
        Index h = first[f];
        for (; h < stop && h < safe; h += kStep) {
          std::fill_n(face + h, kStep, static_cast<Index>(f));
        }
        for (; h < stop; ++h) face[h] = static_cast<Index>(f);
      }
    });
  }

  // Calls visit(h, from, to) for every half-edge, in order.
  template <class Visit>
  void ForEachHalfEdge(const Visit& visit) const {
    const Index* const vertex = mesh_.vertex_.data();
    const Index* const face_begin = mesh_.face_begin_.data();
    const std::size_t faces = input_.face_count();
    for (std::size_t f = 0; f < faces; ++f) {
      const Index begin = face_begin[f];
      const Index last = face_begin[f + 1] - 1;
      for (Index h = begin; h < last; ++h) visit(h, vertex[h], vertex[h + 1]);
      visit(last, vertex[last], vertex[begin]);
    }
  }

  // Each half-edge into the bucket of its end of smaller number, in half-edge order, and the
  // valences. Each range of vertices has one owner who looks at all half-edges: no atomics, and
  // the order does not depend on the threads.
  absl::Status FillBuckets() {
    const std::size_t vertices = input_.vertex_count();
    constexpr int kMostRanges = 8;
    const std::size_t ranges =
        static_cast<std::size_t>(std::clamp(AvailableThreads(), 1, kMostRanges));
    const auto for_each_range = [&](const auto& body) {
      return ParallelFor(context_, ranges, 1, [&](std::size_t first, std::size_t last) {
        const std::size_t lo = vertices * first / ranges;
        body(lo, vertices * last / ranges - lo);
      });
    };
    bucket_begin_.assign(vertices + 1, 0);
    mesh_.fan_begin_.assign(vertices + 1, 0);
    mesh_.vertex_half_edge_.assign(vertices, kNoIndex);
    // Pointers are copied into the loops: looking them up again at each step takes a third of it.
    Index* const fan_begin = mesh_.fan_begin_.data();
    Index* const vertex_half_edge = mesh_.vertex_half_edge_.data();
    Index* const bucket_begin = bucket_begin_.data();
    LIMN_RETURN_IF_ERROR(for_each_range([=, this](std::size_t lo, std::size_t size) {
      ForEachHalfEdge([=](Index h, Index from, Index to) {
        if (from - lo < size) {
          ++fan_begin[from];
          vertex_half_edge[from] = h;
        }
        const Index owner = std::min(from, to);
        if (owner - lo < size) ++bucket_begin[owner];
      });
    }));
    LIMN_RETURN_IF_ERROR(ParallelExclusiveSum(context_, absl::MakeSpan(mesh_.fan_begin_)));
    LIMN_RETURN_IF_ERROR(ParallelExclusiveSum(context_, absl::MakeSpan(bucket_begin_)));
    bucket_.resize(input_.corner_count());
    Buffer<Index> cursors(bucket_begin_);
    Index* const cursor = cursors.data();
    EdgeUse* const bucket = bucket_.data();
    return for_each_range([=, this](std::size_t lo, std::size_t size) {
      ForEachHalfEdge([=](Index h, Index from, Index to) {
        const Index owner = std::min(from, to);
        if (owner - lo < size) {
          bucket[cursor[owner]++] = {.other_end = std::max(from, to), .half_edge = h};
        }
      });
    });
  }

  absl::Status PairTwins() {
    mesh_.twin_.resize(input_.corner_count());
    std::atomic<bool> malformed{false};
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, input_.vertex_count(), [&](std::size_t begin, std::size_t end) {
          bool good = true;
          for (std::size_t v = begin; v < end; ++v) good &= PairBucket(v);
          if (!good) malformed.store(true, std::memory_order_relaxed);
        }));
    if (malformed.load()) return Diagnose();
    bucket_ = {};
    bucket_begin_ = {};
    return absl::OkStatus();
  }

  absl::Status Diagnose() const {
    LIMN_RETURN_IF_ERROR(
        DiagnoseEdges(context_, input_, {.begin = bucket_begin_, .uses = bucket_}));
    return MakeError("half-edges do not pair up", {.reason = Reason::kInternal});
  }

  // Half-edges of the same two ends become twins; alone they are boundary. False when there are
  // more than two, or two of the same direction.
  bool PairBucket(std::size_t v) {
    const auto begin = bucket_.begin() + bucket_begin_[v];
    const auto end = bucket_.begin() + bucket_begin_[v + 1];
    const bool large = static_cast<std::size_t>(end - begin) > kLargeBucket;
    if (large) std::sort(begin, end);
    for (auto a = begin; a != end; ++a) mesh_.twin_[a->half_edge] = kNoIndex;
    for (auto a = begin; a != end; ++a) {
      for (auto b = a + 1; b != end; ++b) {
        if (a->other_end == b->other_end) {
          // At once: a thousand faces at an edge must not be a million pairs.
          if (!Pair(a->half_edge, b->half_edge)) return false;
        } else if (large) {
          break;
        }
      }
    }
    return true;
  }

  bool Pair(Index a, Index b) {
    if (mesh_.vertex_[a] == mesh_.vertex_[b] || mesh_.twin_[a] != kNoIndex ||
        mesh_.twin_[b] != kNoIndex) {
      return false;
    }
    mesh_.twin_[a] = b;
    mesh_.twin_[b] = a;
    return true;
  }

  // The half-edges around each vertex, counter-clockwise, from the boundary if there is one.
  absl::Status OrderFans() {
    const std::size_t vertices = input_.vertex_count();
    mesh_.fan_.resize(input_.corner_count());
    LIMN_RETURN_IF_ERROR(FindNextAround());
    std::vector<FanFindings> blocks((vertices + kScanBlock - 1) / kScanBlock);
    LIMN_RETURN_IF_ERROR(ParallelBlocks(context_, vertices, kScanBlock,
                                        [&](std::size_t block, std::size_t begin, std::size_t end) {
                                          for (std::size_t v = begin; v < end; ++v)
                                            OrderFan(v, &blocks[block]);
                                        }));
    FanFindings all;
    for (const FanFindings& block : blocks) all.Add(block);
    return ReportFans(all);
  }

  // The half-edge that follows each around the vertex that it leaves, counter-clockwise, in one
  // array, so that walks around vertices have one step to wait for. It lives where the edges will.
  absl::Status FindNextAround() {
    mesh_.edge_.resize(input_.corner_count());
    const Index* const first = mesh_.face_begin_.data();
    const Index* const twin = mesh_.twin_.data();
    Index* const next_around = mesh_.edge_.data();
    return ParallelFor(context_, input_.face_count(), [=](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        Index before = first[f + 1] - 1;
        for (Index h = first[f]; h < first[f + 1]; ++h) {
          next_around[h] = twin[before];
          before = h;
        }
      }
    });
  }

  void OrderFan(std::size_t v, FanFindings* findings) {
    const Index begin = mesh_.fan_begin_[v];
    const Index end = mesh_.fan_begin_[v + 1];
    if (begin == end) {
      ++findings->isolated;
      findings->first_isolated = std::min<std::uint64_t>(findings->first_isolated, v);
      return;
    }
    const Index* const next_around = mesh_.edge_.data();
    Index* const fan = mesh_.fan_.data();
    Index start = mesh_.vertex_half_edge_[v];
    Index at = begin;
    Index h = start;
    while (at < end) {
      fan[at++] = h;
      h = next_around[h];
      if (h == start || h == kNoIndex) break;
    }
    if (h == kNoIndex) {
      // A boundary: what lies clockwise of the start comes first.
      const PolygonWalk walk(mesh_);
      const Index counter_clockwise = at - begin;
      for (h = RotateCw(walk, mesh_.twin_, start); h != kNoIndex && at < end;
           h = RotateCw(walk, mesh_.twin_, h)) {
        mesh_.fan_[at++] = h;
        start = h;
      }
      std::reverse(mesh_.fan_.begin() + begin + counter_clockwise, mesh_.fan_.begin() + at);
      std::rotate(mesh_.fan_.begin() + begin, mesh_.fan_.begin() + begin + counter_clockwise,
                  mesh_.fan_.begin() + at);
      mesh_.vertex_half_edge_[v] = start;
    }
    if (at != end) {
      ++findings->multiple;
      findings->first_multiple = std::min<std::uint64_t>(findings->first_multiple, v);
    }
  }

  const Context& context_;
  const PolygonMesh& input_;
  HalfEdgeMesh mesh_;
  // bucket_[bucket_begin_[v] .. bucket_begin_[v + 1]) is the bucket of v.
  Buffer<Index> bucket_begin_;
  Buffer<EdgeUse> bucket_;
};

absl::StatusOr<HalfEdgeMesh> HalfEdgeMesh::Build(const Context& context, const PolygonMesh& mesh) {
  return HalfEdgeMeshBuilder(context, mesh).Build();
}

}  // namespace limn
