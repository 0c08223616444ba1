// SPDX-License-Identifier: MIT
#include "engine/mesh/quad_split.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/edge_numbering.h"

namespace limn {
namespace {

// Calls visit(h, face, next, prev) for the half-edges of [begin, end): walked along, the face and
// its ends need not be looked up for each.
template <class Walk, class Visit>
void VisitCorners(const Walk& walk, std::size_t begin, std::size_t end, const Visit& visit) {
  if (begin >= end) return;
  Index face = walk.Face(static_cast<Index>(begin));
  Index first = walk.FaceBegin(face);
  Index last = walk.FaceEnd(face);
  for (Index h = static_cast<Index>(begin); h < end; ++h) {
    if (h == last) {
      ++face;
      first = last;
      last = walk.FaceEnd(face);
    }
    visit(h, face, h + 1 == last ? first : h + 1, h == first ? last - 1 : h - 1);
  }
}

// Vertices of the quads.
class QuadWriter {
 public:
  QuadWriter(const HalfEdgeMesh& mesh, Index* out)
      : vertex_(mesh.vertex().data()),
        edge_(mesh.edge().data()),
        first_edge_(static_cast<Index>(mesh.vertex_count())),
        first_face_(first_edge_ + static_cast<Index>(mesh.edge_count())),
        out_(out) {}

  void Write(Index h, Index face, Index prev) const {
    Index* const quad = out_ + std::size_t{4} * h;
    quad[0] = vertex_[h];
    quad[1] = first_edge_ + edge_[h];
    quad[2] = first_face_ + face;
    quad[3] = first_edge_ + edge_[prev];
  }

 private:
  const Index* vertex_;
  const Index* edge_;
  Index first_edge_;
  Index first_face_;
  Index* out_;
};

}  // namespace

absl::Status QuadVertices(const Context& context, const HalfEdgeMesh& mesh,
                          absl::Span<Index> vertices) {
  return WithWalk(mesh, [&](auto walk) {
    return ParallelFor(context, mesh.half_edge_count(), [&](std::size_t begin, std::size_t end) {
      const QuadWriter quads(mesh, vertices.data());
      VisitCorners(walk, begin, end, [&](Index h, Index face, Index /*next*/, Index prev) {
        quads.Write(h, face, prev);
      });
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
    LIMN_RETURN_IF_ERROR(WithWalk(in_, [&](auto walk) { return WriteQuads(walk); }));
    // Each old edge gives two, each old half-edge one inside its face.
    LIMN_RETURN_IF_ERROR(NumberEdges(context_, out_.twin_,
                                     2 * in_.edge_count() + in_.half_edge_count(), &out_.edge_,
                                     &out_.edge_half_edge_));
    LIMN_RETURN_IF_ERROR(WithWalk(in_, [&](auto walk) { return WriteVertexHalfEdges(walk); }));
    return std::move(out_);
  }

 private:
  // Vertices and twins.
  template <class Walk>
  absl::Status WriteQuads(const Walk& walk) {
    out_.twin_.resize(out_.vertex_.size());
    const QuadWriter quads(in_, out_.vertex_.data());
    Index* const out = out_.twin_.data();
    const Index* const twins = in_.twin().data();
    return ParallelFor(context_, in_.half_edge_count(), [=](std::size_t begin, std::size_t end) {
      const Walk here = walk;
      VisitCorners(here, begin, end, [=](Index h, Index face, Index next, Index prev) {
        quads.Write(h, face, prev);
        const Index across = twins[h];
        const Index counter_clockwise = twins[prev];
        Index* const twin = out + std::size_t{4} * h;
        twin[0] = across == kNoIndex ? kNoIndex : 4 * here.Next(across) + 3;
        twin[1] = 4 * next + 2;
        twin[2] = 4 * prev + 1;
        twin[3] = counter_clockwise == kNoIndex ? kNoIndex : 4 * counter_clockwise;
      });
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
