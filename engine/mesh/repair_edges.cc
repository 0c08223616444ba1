// SPDX-License-Identifier: MIT
// Edges of more than two faces, taken apart into pairs and single faces.
//
// What is known of the faces around a vertex is kept as arcs: runs of faces that are glued to each
// other, from a side that is not glued to another one. An arc that begins and ends at the same edge
// becomes an umbrella when its ends are glued, so those are glued before anything else; every pair
// joins the arcs at its two ends, which may make more of them.
#include <algorithm>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"

namespace limn::repair {
namespace {

// An end of the i-th crowded side: 2 i at the low vertex, 2 i + 1 at the high one.
using End = std::size_t;
constexpr End kNoEnd = ~End{0};

class CrowdedEdges {
 public:
  CrowdedEdges(const Context& context, const EdgeList& crowded, Patchwork* patchwork)
      : context_(context), crowded_(crowded), p_(*patchwork) {}

  absl::Status Run() {
    LIMN_RETURN_IF_ERROR(FindArcs());
    LIMN_RETURN_IF_ERROR(ForInOrder(context_, arc_.size(), [&](std::size_t begin, std::size_t end) {
      for (End at = begin; at < end; ++at) {
        closable_.push_back(at);
        CloseUmbrellas();
      }
    }));
    return ForInOrder(context_, crowded_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) PairRest(e);
    });
  }

 private:
  absl::Status FindArcs() {
    const std::size_t sides = crowded_.side.size();
    edge_.resize(sides);
    Buffer<Index> number(p_.corner_count(), kNoIndex);
    for (std::size_t e = 0; e < crowded_.size(); ++e) {
      for (Index i = crowded_.begin[e]; i < crowded_.begin[e + 1]; ++i) {
        edge_[i] = static_cast<Index>(e);
        number[crowded_.side[i]] = i;
      }
    }
    arc_.resize(2 * sides);
    return ParallelFor(context_, sides, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Index side = crowded_.side[i];
        arc_[2 * i] = OtherEnd(side, p_.Low(side), number);
        arc_[2 * i + 1] = OtherEnd(side, p_.High(side), number);
      }
    });
  }

  // Walks around the vertex from a side that is not glued to the next such side.
  End OtherEnd(Index side, Index vertex, const Buffer<Index>& number) const {
    for (;;) {
      const Index corner = p_.CornerAt(side, vertex);
      side = side == corner ? p_.Prev(corner) : corner;
      if (p_.mate[side] == kNoIndex) break;
      side = p_.mate[side];
    }
    if (number[side] == kNoIndex) return kNoEnd;
    return 2 * End{number[side]} + (p_.Low(side) == vertex ? 0 : 1);
  }

  Index SideOf(End end) const { return crowded_.side[end / 2]; }
  bool Single(Index side) const { return p_.mate[side] == kNoIndex; }

  // Whether gluing the two ends of an arc would close an umbrella.
  bool Closable(End a, End b) const {
    if (a == kNoEnd || b == kNoEnd || edge_[a / 2] != edge_[b / 2]) return false;
    const Index s = SideOf(a);
    const Index t = SideOf(b);
    return Single(s) && Single(t) && p_.Ascends(s) != p_.Ascends(t);
  }

  // Glues what can be glued of the arcs that were put on the list, and of those that this makes.
  void CloseUmbrellas() {
    while (!closable_.empty()) {
      const End a = closable_.back();
      closable_.pop_back();
      const End b = arc_[a];
      if (Closable(a, b)) Pair(a / 2, b / 2);
    }
  }

  // Glues two sides of an edge, given by their numbers.
  void Pair(std::size_t i, std::size_t j) {
    p_.Glue(crowded_.side[i], crowded_.side[j]);
    for (const End at : {0, 1}) {
      const End a = arc_[2 * i + at];
      const End b = arc_[2 * j + at];
      if (a != kNoEnd) arc_[a] = b;
      if (b != kNoEnd) arc_[b] = a;
      if (Closable(a, b)) closable_.push_back(a);
    }
  }

  // Pairs what no umbrella decides.
  void PairRest(std::size_t edge) {
    singles_.clear();
    singles_.reserve(crowded_.begin[edge + 1] - crowded_.begin[edge]);
    for (Index i = crowded_.begin[edge]; i < crowded_.begin[edge + 1]; ++i) {
      if (Single(crowded_.side[i])) singles_.push_back(i);
    }
    const auto middle = std::partition(singles_.begin(), singles_.end(),
                                       [&](Index i) { return p_.Ascends(crowded_.side[i]); });
    const auto ups = static_cast<std::size_t>(middle - singles_.begin());
    if (ups == 0 || ups == singles_.size()) return;
    // Sides are numbered in the order of their faces.
    const auto before = [&](Index i, Index j) {
      return std::pair(Rank(i), i) < std::pair(Rank(j), j);
    };
    std::sort(singles_.begin(), middle, before);
    std::sort(middle, singles_.end(), before);
    const auto up = absl::MakeConstSpan(singles_).first(ups);
    const auto down = absl::MakeConstSpan(singles_).subspan(ups);
    PairWithinComponents(up, down);
    PairInOrder(up, down);
  }

  Index ComponentOf(Index i) const { return p_.component[p_.corner_face[crowded_.side[i]]]; }

  // Large components first.
  std::pair<Index, Index> Rank(Index i) const {
    const Index component = ComponentOf(i);
    return {~p_.component_size[component], component};
  }

  // The sides of the first one's component.
  absl::Span<const Index> FirstComponent(absl::Span<const Index> sides) const {
    std::size_t n = 0;
    while (n < sides.size() && ComponentOf(sides[n]) == ComponentOf(sides[0])) ++n;
    return sides.first(n);
  }

  // up, down: by rank. Both are walked once, component by component.
  void PairWithinComponents(absl::Span<const Index> up, absl::Span<const Index> down) {
    while (!up.empty() && !down.empty()) {
      const auto a = Rank(up[0]);
      const auto b = Rank(down[0]);
      const auto up_first = a <= b ? FirstComponent(up) : absl::Span<const Index>();
      const auto down_first = b <= a ? FirstComponent(down) : absl::Span<const Index>();
      PairInOrder(up_first, down_first);
      up.remove_prefix(up_first.size());
      down.remove_prefix(down_first.size());
    }
  }

  // The first single one with the first single one, again and again.
  void PairInOrder(absl::Span<const Index> up, absl::Span<const Index> down) {
    for (std::size_t i = 0, j = 0;;) {
      while (i < up.size() && !Single(crowded_.side[up[i]])) ++i;
      while (j < down.size() && !Single(crowded_.side[down[j]])) ++j;
      if (i == up.size() || j == down.size()) return;
      Pair(up[i], down[j]);
      CloseUmbrellas();
    }
  }

  const Context& context_;
  const EdgeList& crowded_;
  Patchwork& p_;
  // Per crowded side: its edge.
  Buffer<Index> edge_;
  // Per end: the other end of the arc that begins there, kNoEnd where it ends at another kind of
  // side. Ends that have been glued are not kept up to date.
  Buffer<End> arc_;
  // One end of each arc that can perhaps be closed.
  Buffer<End> closable_;
  // The sides of an edge that are not glued: those that ascend, then the others.
  Buffer<Index> singles_;
};

}  // namespace

absl::Status PairCrowdedEdges(const Context& context, const EdgeList& crowded,
                              Patchwork* patchwork) {
  if (crowded.size() == 0) return absl::OkStatus();
  return CrowdedEdges(context, crowded, patchwork).Run();
}

}  // namespace limn::repair
