// SPDX-License-Identifier: MIT
// Faces that stand for as many faces one way round as the other.
#include "engine/base/disjoint_sets.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"

namespace limn::repair {
namespace {

// Folds hang together across edges of folded faces only. Edges that they share with others are
// their rim.
class FoldRemover {
 public:
  FoldRemover(const Context& context, const EdgeTable& edges, const Buffer<std::uint8_t>& folded,
              Patchwork* patchwork)
      : context_(context),
        edges_(edges),
        folded_(folded),
        p_(*patchwork),
        folds_(folded.size()),
        rim_(folded.size(), kNone) {}

  absl::Status Run() {
    LIMN_RETURN_IF_ERROR(
        ForInOrder(context_, edges_.vertex_count(), [&](std::size_t begin, std::size_t end) {
          for (std::size_t v = begin; v < end; ++v) {
            edges_.ForEachEdge(
                v, [&](absl::Span<const EdgeTable::Entry> sides) { LookAtEdge(sides); });
          }
        }));
    const auto for_each_folded = [&](const auto& visit) {
      return ForInOrder(context_, folded_.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
          if (folded_[f] != 0) visit(static_cast<Index>(f));
        }
      });
    };
    LIMN_RETURN_IF_ERROR(for_each_folded([&](Index f) { rim_[folds_.Find(f)] |= rim_[f]; }));
    return for_each_folded([&](Index f) {
      if (rim_[folds_.Find(f)] != kHangs) return;
      p_.state[f] = FaceState::kRemoved;
      ++removed_;
    });
  }

  std::uint64_t removed() const { return removed_; }

 private:
  // What the rim of a face or fold is like; bits.
  enum Rim : std::uint8_t { kNone = 0, kHangs = 1, kHeld = 2 };

  void LookAtEdge(absl::Span<const EdgeTable::Entry> sides) {
    std::size_t others = 0;
    faces_.clear();
    for (const auto& entry : sides) {
      const Index f = p_.corner_face[entry.side];
      if (!p_.live(f)) continue;
      if (folded_[f] == 0) {
        ++others;
      } else {
        faces_.push_back(f);
      }
    }
    if (others == 0) {
      for (const Index f : faces_) folds_.Merge(faces_[0], f);
      return;
    }
    for (const Index f : faces_) rim_[f] |= others == 1 ? kHeld : kHangs;
  }

  const Context& context_;
  const EdgeTable& edges_;
  const Buffer<std::uint8_t>& folded_;
  Patchwork& p_;
  DisjointSets folds_;
  // Per face; finally per fold.
  Buffer<std::uint8_t> rim_;
  Buffer<Index> faces_;
  std::uint64_t removed_ = 0;
};

}  // namespace

absl::Status RemoveFolds(const Context& context, const EdgeTable& edges,
                         const Buffer<std::uint8_t>& folded, Patchwork* patchwork,
                         RepairReport* report) {
  FoldRemover remover(context, edges, folded, patchwork);
  LIMN_RETURN_IF_ERROR(remover.Run());
  report->folded_faces_removed = remover.removed();
  return absl::OkStatus();
}

}  // namespace limn::repair
