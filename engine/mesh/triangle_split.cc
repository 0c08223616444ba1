// SPDX-License-Identifier: MIT
#include "engine/mesh/triangle_split.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/edge_numbering.h"

namespace limn {
namespace {

void WriteTriangles(const HalfEdgeMesh& mesh, std::size_t begin, std::size_t end, Index* out) {
  const Index* const vertex = mesh.vertex().data();
  const Index* const edge = mesh.edge().data();
  const Index first_edge = static_cast<Index>(mesh.vertex_count());
  for (std::size_t f = begin; f < end; ++f) {
    const Index e[3] = {first_edge + edge[3 * f], first_edge + edge[3 * f + 1],
                        first_edge + edge[3 * f + 2]};
    Index* const triangle = out + 12 * f;
    for (std::size_t i = 0; i < 3; ++i) {
      triangle[3 * i] = vertex[3 * f + i];
      triangle[3 * i + 1] = e[i];
      triangle[3 * i + 2] = e[(i + 2) % 3];
      triangle[9 + i] = e[i];
    }
  }
}

}  // namespace

absl::Status RequireTriangles(const HalfEdgeMesh& mesh) {
  // Faces have at least three corners.
  if (mesh.half_edge_count() == 3 * mesh.face_count()) return absl::OkStatus();
  if (mesh.arity() != 0) {
    return MakeError(
        absl::StrCat("Loop subdivision needs triangles: all faces have ", mesh.arity(), " corners"),
        {.reason = Reason::kInvalidOption,
         .field = "mesh.faces",
         .index = 0,
         .remedy = "Triangulate the mesh, or choose another scheme"});
  }
  std::uint64_t others = 0;
  std::uint64_t first = 0;
  for (std::size_t f = mesh.face_count(); f-- > 0;) {
    if (mesh.face_begin()[f + 1] - mesh.face_begin()[f] == 3) continue;
    ++others;
    first = f;
  }
  return MakeError(absl::StrCat("Loop subdivision needs triangles: ", others,
                                " faces have more corners, first face ", first),
                   {.reason = Reason::kInvalidOption,
                    .field = "mesh.faces",
                    .index = first,
                    .remedy = "Triangulate the mesh, or choose another scheme"});
}

absl::Status TriangleVertices(const Context& context, const HalfEdgeMesh& mesh,
                              absl::Span<Index> vertices) {
  LIMN_RETURN_IF_ERROR(RequireTriangles(mesh));
  return ParallelFor(context, mesh.face_count(), [&](std::size_t begin, std::size_t end) {
    WriteTriangles(mesh, begin, end, vertices.data());
  });
}

// Fills the arrays of the split mesh.
class TriangleSplitter {
 public:
  TriangleSplitter(const Context& context, const HalfEdgeMesh& mesh)
      : context_(context), in_(mesh), walk_(mesh) {}

  absl::StatusOr<HalfEdgeMesh> Split() {
    LIMN_RETURN_IF_ERROR(RequireTriangles(in_));
    const std::uint64_t half_edges = 4 * std::uint64_t{in_.half_edge_count()};
    if (half_edges >= kNoIndex) {
      return MakeError(absl::StrCat("the refined mesh would have ", half_edges, " half-edges"),
                       {.reason = Reason::kLimitExceeded,
                        .field = "surface.level",
                        .remedy = "Choose a lower level"});
    }
    out_.arity_ = 3;
    out_.vertex_.resize(half_edges);
    LIMN_RETURN_IF_ERROR(TriangleVertices(context_, in_, absl::MakeSpan(out_.vertex_)));
    LIMN_RETURN_IF_ERROR(WriteTwins());
    // Each old edge gives two, each old half-edge one inside its face.
    LIMN_RETURN_IF_ERROR(NumberEdges(context_, out_.twin_,
                                     2 * in_.edge_count() + in_.half_edge_count(), &out_.edge_,
                                     &out_.edge_half_edge_));
    LIMN_RETURN_IF_ERROR(WriteVertexHalfEdges());
    return std::move(out_);
  }

 private:
  absl::Status WriteTwins() {
    out_.twin_.resize(out_.vertex_.size());
    return ParallelFor(context_, in_.face_count(), [&](std::size_t begin, std::size_t end) {
      for (Index f = static_cast<Index>(begin); f < end; ++f) {
        Index* const twin = &out_.twin_[12 * std::size_t{f}];
        const Index middle = 12 * f + 9;
        for (Index i = 0; i < 3; ++i) {
          const Index clockwise = RotateCw(walk_, in_.twin(), 3 * f + i);
          const Index counter_clockwise = RotateCcw(walk_, in_.twin(), 3 * f + i);
          const Index previous = (i + 2) % 3;
          twin[3 * i] = clockwise == kNoIndex ? kNoIndex : 3 * CornerTriangle(clockwise) + 2;
          twin[3 * i + 1] = middle + previous;
          twin[3 * i + 2] =
              counter_clockwise == kNoIndex ? kNoIndex : 3 * CornerTriangle(counter_clockwise);
          twin[9 + previous] = 12 * f + 3 * i + 1;
        }
      }
    });
  }

  // At a boundary these are the half-edges that run along it, as fans need.
  absl::Status WriteVertexHalfEdges() {
    const std::size_t vertices = in_.vertex_count();
    const std::size_t edges = in_.edge_count();
    out_.vertex_half_edge_.resize(vertices + edges);
    Index* const out = out_.vertex_half_edge_.data();
    LIMN_RETURN_IF_ERROR(ParallelFor(context_, vertices, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        out[v] = 3 * CornerTriangle(in_.vertex_half_edge()[v]);
      }
    }));
    return ParallelFor(context_, edges, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        out[vertices + e] = 3 * CornerTriangle(walk_.Next(in_.edge_half_edge()[e])) + 2;
      }
    });
  }

  const Context& context_;
  const HalfEdgeMesh& in_;
  const TriangleWalk walk_;
  HalfEdgeMesh out_;
};

absl::StatusOr<HalfEdgeMesh> SplitIntoTriangles(const Context& context, const HalfEdgeMesh& mesh) {
  return TriangleSplitter(context, mesh).Split();
}

}  // namespace limn
