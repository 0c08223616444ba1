// SPDX-License-Identifier: MIT
#include "engine/mesh/quad_split.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/edge_numbering.h"

namespace limn {
namespace {

template <class Walk>
void WriteQuads(const Walk& walk, const HalfEdgeMesh& mesh, std::size_t begin, std::size_t end,
                Index* out) {
  const Index first_edge = static_cast<Index>(mesh.vertex_count());
  const Index first_face = first_edge + static_cast<Index>(mesh.edge_count());
  const Index* const vertex = mesh.vertex().data();
  const Index* const edge = mesh.edge().data();
  for (std::size_t h = begin; h < end; ++h) {
    const Index half_edge = static_cast<Index>(h);
    out[4 * h] = vertex[h];
    out[4 * h + 1] = first_edge + edge[h];
    out[4 * h + 2] = first_face + walk.Face(half_edge);
    out[4 * h + 3] = first_edge + edge[walk.Prev(half_edge)];
  }
}

}  // namespace

absl::Status QuadVertices(const Context& context, const HalfEdgeMesh& mesh,
                          absl::Span<Index> vertices) {
  return WithWalk(mesh, [&](auto walk) {
    return ParallelFor(context, mesh.half_edge_count(), [&](std::size_t begin, std::size_t end) {
      WriteQuads(walk, mesh, begin, end, vertices.data());
    });
  });
}

// Fills the arrays of the split mesh.
class QuadSplitter {
 public:
  QuadSplitter(const Context& context, const HalfEdgeMesh& mesh) : context_(context), in_(mesh) {}

  absl::StatusOr<HalfEdgeMesh> Split() {
    const std::uint64_t half_edges = 4 * std::uint64_t{in_.half_edge_count()};
    if (half_edges >= kNoIndex) {
      return MakeError(absl::StrCat("the refined mesh would have ", half_edges, " half-edges"),
                       {.reason = Reason::kLimitExceeded,
                        .field = "surface.level",
                        .remedy = "Choose a lower level"});
    }
    out_.arity_ = 4;
    out_.vertex_.resize(half_edges);
    LIMN_RETURN_IF_ERROR(QuadVertices(context_, in_, absl::MakeSpan(out_.vertex_)));
    LIMN_RETURN_IF_ERROR(WithWalk(in_, [&](auto walk) { return WriteTwins(walk); }));
    // Each old edge gives two, each old half-edge one inside its face.
    LIMN_RETURN_IF_ERROR(NumberEdges(context_, out_.twin_,
                                     2 * in_.edge_count() + in_.half_edge_count(), &out_.edge_,
                                     &out_.edge_half_edge_));
    LIMN_RETURN_IF_ERROR(WithWalk(in_, [&](auto walk) { return WriteVertexHalfEdges(walk); }));
    return std::move(out_);
  }

 private:
  template <class Walk>
  absl::Status WriteTwins(const Walk& walk) {
    out_.twin_.resize(out_.vertex_.size());
    Index* const out = out_.twin_.data();
    const absl::Span<const Index> twins = in_.twin();
    return ParallelFor(context_, in_.half_edge_count(), [=](std::size_t begin, std::size_t end) {
      const Walk here = walk;
      for (std::size_t i = begin; i < end; ++i) {
        const Index h = static_cast<Index>(i);
        const Index clockwise = RotateCw(here, twins, h);
        const Index counter_clockwise = RotateCcw(here, twins, h);
        Index* const twin = out + 4 * i;
        twin[0] = clockwise == kNoIndex ? kNoIndex : 4 * clockwise + 3;
        twin[1] = 4 * here.Next(h) + 2;
        twin[2] = 4 * here.Prev(h) + 1;
        twin[3] = counter_clockwise == kNoIndex ? kNoIndex : 4 * counter_clockwise;
      }
    });
  }

  // At a boundary these are the half-edges that run along it, as fans need.
  template <class Walk>
  absl::Status WriteVertexHalfEdges(const Walk& walk) {
    const std::size_t vertices = in_.vertex_count();
    const std::size_t edges = in_.edge_count();
    out_.vertex_half_edge_.resize(vertices + edges + in_.face_count());
    Index* const out = out_.vertex_half_edge_.data();
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, vertices, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) out[v] = 4 * in_.vertex_half_edge()[v];
    }));
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, edges, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        out[vertices + e] = 4 * walk.Next(in_.edge_half_edge()[e]) + 3;
      }
    }));
    return ParallelFor(context_, in_.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        out[vertices + edges + f] = 4 * walk.FaceBegin(static_cast<Index>(f)) + 2;
      }
    });
  }

  const Context& context_;
  const HalfEdgeMesh& in_;
  HalfEdgeMesh out_;
};

absl::StatusOr<HalfEdgeMesh> SplitIntoQuads(const Context& context, const HalfEdgeMesh& mesh) {
  return QuadSplitter(context, mesh).Split();
}

}  // namespace limn
