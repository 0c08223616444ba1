// SPDX-License-Identifier: MIT
// Components, and one orientation for each.
#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"

namespace limn::repair {
namespace {

class Orienter {
 public:
  Orienter(const Context& context, Patchwork* patchwork)
      : context_(context), p_(*patchwork), queue_(patchwork->face_count()) {}

  absl::Status Run() {
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context_, p_.face_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t f = begin; f < end; ++f) {
            if (p_.live(f) && p_.component[f] == kNoIndex) Flood(static_cast<Index>(f));
          }
        }));
    return context_.Check();
  }

  // Whether some component has no orientation.
  bool conflict() const { return conflict_; }

 private:
  // Breadth-first from a face that keeps its orientation, until the job is to stop; then the side
  // with fewer faces is turned.
  void Flood(Index root) {
    const auto id = static_cast<Index>(p_.component_size.size());
    std::size_t turned = 0;
    std::size_t size = 0;
    queue_[size++] = root;
    p_.component[root] = id;
    for (std::size_t at = 0; at < size; ++at) {
      if (at % kDefaultGrain == 0 && context_.stop_requested()) return;
      const Index f = queue_[at];
      turned += p_.turned[f];
      for (Index side = p_.face_begin[f]; side < p_.face_begin[f + 1]; ++side) {
        const Index mate = p_.mate[side];
        if (mate == kNoIndex) continue;
        const Index g = p_.corner_face[mate];
        // As they were given, sides that leave the same vertex run the same way.
        const bool same_way = p_.corner_vertex[side] == p_.corner_vertex[mate];
        const auto wanted = static_cast<std::uint8_t>(p_.turned[f] ^ (same_way ? 1 : 0));
        if (p_.component[g] != kNoIndex) {
          conflict_ = conflict_ || p_.turned[g] != wanted;
          continue;
        }
        p_.component[g] = id;
        p_.turned[g] = wanted;
        queue_[size++] = g;
      }
    }
    p_.component_size.push_back(static_cast<Index>(size));
    if (2 * turned <= size) return;
    for (std::size_t i = 0; i < size; ++i) p_.turned[queue_[i]] ^= 1;
  }

  const Context& context_;
  Patchwork& p_;
  Buffer<Index> queue_;
  bool conflict_ = false;
};

// Unglues the sides that run the same way.
absl::Status CutConflicts(const Context& context, Patchwork* patchwork, EdgeList* cut) {
  Patchwork& p = *patchwork;
  return ForInOrder(context, p.corner_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const Index side = static_cast<Index>(c);
      const Index mate = p.mate[side];
      if (mate == kNoIndex || mate < side || p.Ascends(side) != p.Ascends(mate)) continue;
      p.Unglue(side);
      cut->side.push_back(side);
      cut->side.push_back(mate);
      cut->EndEdge();
    }
  });
}

}  // namespace

absl::Status GlueEdges(const Context& context, const EdgeTable& edges, Patchwork* patchwork,
                       EdgeList* crowded) {
  Patchwork& p = *patchwork;
  return ForInOrder(context, edges.vertex_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      edges.ForEachEdge(v, [&](absl::Span<const EdgeTable::Entry> sides) {
        const std::size_t first = crowded->side.size();
        for (const auto& entry : sides) {
          if (p.live(p.corner_face[entry.side])) crowded->side.push_back(entry.side);
        }
        const std::size_t count = crowded->side.size() - first;
        if (count > 2) {
          crowded->EndEdge();
          return;
        }
        if (count == 2) p.Glue(crowded->side[first], crowded->side[first + 1]);
        crowded->side.resize(first);
      });
    }
  });
}

absl::Status OrientFaces(const Context& context, bool turn, Patchwork* patchwork, EdgeList* cut,
                         RepairReport* report) {
  Orienter orienter(context, patchwork);
  LIMN_RETURN_IF_ERROR(orienter.Run());
  if (!turn) {
    std::fill(patchwork->turned.begin(), patchwork->turned.end(), std::uint8_t{0});
    return absl::OkStatus();
  }
  if (orienter.conflict()) LIMN_RETURN_IF_ERROR(CutConflicts(context, patchwork, cut));
  report->edges_cut = cut->size();
  report->faces_reoriented = static_cast<std::uint64_t>(
      std::count(patchwork->turned.begin(), patchwork->turned.end(), std::uint8_t{1}));
  return absl::OkStatus();
}

}  // namespace limn::repair
