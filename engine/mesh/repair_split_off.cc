// SPDX-License-Identifier: MIT
// Pairs of the same edge that share both umbrellas.
//
// A face that is split off gets a corner, and so a vertex, that no other face has, so both its
// sides there share their ends with nothing. What was glued to these sides keeps its own ends,
// which part at the most: one pass is enough.
#include <algorithm>
#include <tuple>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"

namespace limn::repair {
namespace {

// Finds, in a list of edges, sides that have both ends in common without being glued.
class CoincidenceFinder {
 public:
  CoincidenceFinder(Patchwork* patchwork, DisjointSets* corners)
      : p_(*patchwork), corners_(*corners) {}

  // sides: of one edge, before the split.
  void Look(absl::Span<const Index> sides) {
    found_.clear();
    for (const Index side : sides) {
      found_.push_back({corners_.Find(p_.CornerAt(side, p_.Low(side))),
                        corners_.Find(p_.CornerAt(side, p_.High(side))), side});
    }
    std::sort(found_.begin(), found_.end());
    for (std::size_t begin = 0, end = 0; begin < found_.size(); begin = end) {
      while (end < found_.size() && SameEnds(found_[begin], found_[end])) ++end;
      LookAtSameEnds(absl::MakeConstSpan(found_).subspan(begin, end - begin));
    }
  }

  // Corners that must have a vertex of their own.
  const Buffer<Index>& corners() const { return split_off_; }

 private:
  // Classes at the low and at the high end, and the side.
  using Found = std::tuple<Index, Index, Index>;

  static bool SameEnds(const Found& a, const Found& b) {
    return std::get<0>(a) == std::get<0>(b) && std::get<1>(a) == std::get<1>(b);
  }

  void LookAtSameEnds(absl::Span<const Found> sides) {
    if (sides.size() < 2) return;
    // The first pair stays, or the first side where there is none.
    Index stays = std::get<2>(sides[0]);
    for (const auto& [low, high, side] : sides) {
      if (p_.mate[side] == kNoIndex) continue;
      stays = side;
      break;
    }
    for (const auto& [low, high, side] : sides) {
      if (side != stays && side != p_.mate[stays]) {
        split_off_.push_back(p_.CornerAt(side, p_.Low(side)));
      }
    }
  }

  Patchwork& p_;
  DisjointSets& corners_;
  Buffer<Found> found_;
  Buffer<Index> split_off_;
};

}  // namespace

absl::Status JoinCorners(const Context& context, const Patchwork& patchwork,
                         DisjointSets* corners) {
  const Patchwork& p = patchwork;
  return ForInOrder(context, p.corner_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const Index side = static_cast<Index>(c);
      const Index mate = p.mate[side];
      if (mate == kNoIndex || mate < side) continue;
      for (const Index corner : {side, p.Next(side)}) {
        corners->Merge(corner, p.CornerAt(mate, p.corner_vertex[corner]));
      }
    }
  });
}

absl::Status SplitOffFaces(const Context& context, absl::Span<const EdgeList* const> edges,
                           Patchwork* patchwork, RepairReport* report) {
  Patchwork& p = *patchwork;
  if (std::all_of(edges.begin(), edges.end(), [](const EdgeList* l) { return l->size() == 0; })) {
    return absl::OkStatus();
  }
  DisjointSets corners(p.corner_count());
  LIMN_RETURN_IF_ERROR(JoinCorners(context, p, &corners));
  CoincidenceFinder finder(patchwork, &corners);
  for (const EdgeList* list : edges) {
    LIMN_RETURN_IF_ERROR(ForInOrder(context, list->size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) finder.Look(list->sides(e));
    }));
  }
  Buffer<Index> faces;
  for (const Index corner : finder.corners()) {
    p.Unglue(corner);
    p.Unglue(p.Prev(corner));
    faces.push_back(p.corner_face[corner]);
  }
  std::sort(faces.begin(), faces.end());
  report->faces_split_off =
      static_cast<std::uint64_t>(std::unique(faces.begin(), faces.end()) - faces.begin());
  return context.Check();
}

}  // namespace limn::repair
