// SPDX-License-Identifier: MIT
// Vertices as classes of corners that are joined across glued sides; a class is named by its
// smallest corner.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/disjoint_sets.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"

namespace limn::repair {
namespace {

class VertexNumberer {
 public:
  VertexNumberer(const Context& context, std::size_t vertices, const RepairOptions& options,
                 Patchwork* patchwork, RepairReport* report)
      : context_(context),
        vertices_(vertices),
        options_(options),
        p_(*patchwork),
        report_(*report),
        corners_(options.non_manifold ? patchwork->corner_count() : 0),
        keeper_(vertices, kNoIndex) {}

  absl::StatusOr<VertexNumbers> Run() {
    if (options_.non_manifold) LIMN_RETURN_IF_ERROR(JoinCorners(context_, p_, &corners_));
    LIMN_RETURN_IF_ERROR(FindClasses(FaceState::kLive));
    LIMN_RETURN_IF_ERROR(FindClasses(FaceState::kAside));
    LIMN_RETURN_IF_ERROR(NumberKept());
    LIMN_RETURN_IF_ERROR(NumberCopies());
    LIMN_RETURN_IF_ERROR(FillCorners());
    return std::move(numbers_);
  }

 private:
  // Calls visit(c) for the corners of faces in that state, in order.
  template <class Visit>
  absl::Status ForEachCorner(FaceState state, const Visit& visit) const {
    return ForInOrder(context_, p_.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        if (p_.state[f] != state) continue;
        for (Index c = p_.face_begin[f]; c < p_.face_begin[f + 1]; ++c) visit(c);
      }
    });
  }

  bool Splits(FaceState state) const { return options_.non_manifold && state == FaceState::kLive; }

  // The first class of each vertex keeps it, the others become copies.
  absl::Status FindClasses(FaceState state) {
    return ForEachCorner(state, [&](Index c) {
      const Index v = p_.corner_vertex[c];
      if (Splits(state) && corners_.Find(c) != c) return;
      if (keeper_[v] == kNoIndex) {
        keeper_[v] = c;
      } else if (Splits(state)) {
        copies_.push_back({v, c});
      }
    });
  }

  absl::Status NumberKept() {
    new_vertex_.resize(vertices_);
    Buffer<Index>& original = numbers_.original_vertex;
    original.resize(vertices_);
    std::size_t kept = 0;
    LIMN_RETURN_IF_ERROR(ForInOrder(context_, vertices_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        if (keeper_[v] == kNoIndex && options_.isolated_vertices) continue;
        new_vertex_[v] = static_cast<Index>(kept);
        original[kept++] = static_cast<Index>(v);
      }
    }));
    numbers_.kept = kept;
    report_.isolated_vertices_removed = vertices_ - kept;
    return CheckLimit(std::uint64_t{kept} + copies_.size());
  }

  absl::Status CheckLimit(std::uint64_t vertices) const {
    const std::uint64_t limit =
        std::min<std::uint64_t>(context_.limits().max_vertices, kNoIndex - 1);
    if (vertices <= limit) return absl::OkStatus();
    return MakeError(
        absl::StrCat("the repaired mesh would have ", vertices, " vertices, the limit is ", limit),
        {.reason = Reason::kLimitExceeded,
         .field = "mesh.vertices",
         .remedy = "Send a smaller mesh or raise the limit"});
  }

  // Mates are not needed any more: their place takes the numbers of copies, per class.
  absl::Status NumberCopies() {
    std::sort(copies_.begin(), copies_.end());
    numbers_.original_vertex.resize(numbers_.kept + copies_.size());
    for (std::size_t i = 0; i < copies_.size(); ++i) {
      const auto& [vertex, corner] = copies_[i];
      numbers_.original_vertex[numbers_.kept + i] = vertex;
      p_.mate[corner] = static_cast<Index>(numbers_.kept + i);
      report_.vertices_split += i == 0 || copies_[i - 1].first != vertex ? 1 : 0;
    }
    report_.vertices_added = copies_.size();
    return context_.Check();
  }

  absl::Status FillCorners() {
    numbers_.corner_vertex.resize(p_.corner_count());
    for (const FaceState state : {FaceState::kLive, FaceState::kAside}) {
      LIMN_RETURN_IF_ERROR(ForEachCorner(state, [&](Index c) {
        const Index v = p_.corner_vertex[c];
        const Index name = Splits(state) ? corners_.Find(c) : keeper_[v];
        numbers_.corner_vertex[c] = name == keeper_[v] ? new_vertex_[v] : p_.mate[name];
      }));
    }
    return absl::OkStatus();
  }

  const Context& context_;
  const std::size_t vertices_;
  const RepairOptions& options_;
  Patchwork& p_;
  RepairReport& report_;
  DisjointSets corners_;
  // Per vertex: the class that keeps it, or kNoIndex; its new number.
  Buffer<Index> keeper_;
  Buffer<Index> new_vertex_;
  // Vertex and class.
  Buffer<std::pair<Index, Index>> copies_;
  VertexNumbers numbers_;
};

}  // namespace

absl::StatusOr<VertexNumbers> NumberVertices(const Context& context, std::size_t vertices,
                                             const RepairOptions& options, Patchwork* patchwork,
                                             RepairReport* report) {
  return VertexNumberer(context, vertices, options, patchwork, report).Run();
}

}  // namespace limn::repair
