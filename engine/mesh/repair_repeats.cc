// SPDX-License-Identifier: MIT
// Faces that have the vertices of an earlier one. Faces are read from their smallest vertex towards
// the smaller of its neighbours: the same vertices in the same cyclic order, forwards or backwards,
// read the same. The side along which such a reading starts is the face's first side; only faces
// that start along the same edge need to be compared.
#include <algorithm>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/mesh/repair_patchwork.h"

namespace limn::repair {
namespace {

class RepeatFinder {
 public:
  RepeatFinder(const Context& context, const EdgeTable& edges, Patchwork* patchwork)
      : context_(context), edges_(edges), p_(*patchwork), folded_(patchwork->face_count(), 0) {}

  absl::Status Run() {
    LIMN_RETURN_IF_ERROR(FindFirstSides());
    LIMN_RETURN_IF_ERROR(FindCrowdedSides());
    LIMN_RETURN_IF_ERROR(
        ParallelFor(context_, edges_.vertex_count(), [&](std::size_t begin, std::size_t end) {
          std::vector<Index> faces;
          for (std::size_t v = begin; v < end; ++v) {
            edges_.ForEachEdge(v, [&](absl::Span<const EdgeTable::Entry> sides) {
              // A face without company repeats none.
              if (sides.size() < 2) return;
              faces.clear();
              for (const auto& entry : sides) {
                const Index f = p_.corner_face[entry.side];
                if (first_side_[f] == entry.side) faces.push_back(f);
              }
              if (faces.size() > 1) Remove(&faces);
            });
          }
        }));
    return context_.Check();
  }

  // Per face: whether it stays for as many faces one way round as the other.
  const Buffer<std::uint8_t>& folded() const { return folded_; }

 private:
  absl::Status FindFirstSides() {
    first_side_.resize(p_.face_count());
    return ParallelFor(context_, p_.face_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = begin; f < end; ++f) {
        if (!p_.live(f)) continue;
        const absl::Span<const Index> face = p_.face(f);
        const auto lowest = std::min_element(face.begin(), face.end());
        const Index c = p_.face_begin[f] + static_cast<Index>(lowest - face.begin());
        const bool forwards = p_.corner_vertex[p_.Next(c)] < p_.corner_vertex[p_.Prev(c)];
        first_side_[f] = forwards ? c : p_.Prev(c);
      }
    });
  }

  absl::Status FindCrowdedSides() {
    crowded_.resize(p_.corner_count());
    return ParallelFor(context_, edges_.vertex_count(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        edges_.ForEachEdge(v, [&](absl::Span<const EdgeTable::Entry> sides) {
          for (const auto& entry : sides) crowded_[entry.side] = sides.size() > 2 ? 1 : 0;
        });
      }
    });
  }

  bool Forwards(Index face) const {
    const Index side = first_side_[face];
    return p_.corner_vertex[side] < p_.corner_vertex[p_.Next(side)];
  }

  // Below, at or above zero as the reading of face a sorts before, with or after that of b.
  int Compare(Index a, Index b) const {
    const std::size_t size = p_.face(a).size();
    if (size != p_.face(b).size()) return size < p_.face(b).size() ? -1 : 1;
    const bool a_forwards = Forwards(a);
    const bool b_forwards = Forwards(b);
    Index at_a = a_forwards ? first_side_[a] : p_.Next(first_side_[a]);
    Index at_b = b_forwards ? first_side_[b] : p_.Next(first_side_[b]);
    for (std::size_t i = 0; i < size; ++i) {
      const Index v = p_.corner_vertex[at_a];
      const Index w = p_.corner_vertex[at_b];
      if (v != w) return v < w ? -1 : 1;
      at_a = a_forwards ? p_.Next(at_a) : p_.Prev(at_a);
      at_b = b_forwards ? p_.Next(at_b) : p_.Prev(at_b);
    }
    return 0;
  }

  // faces: in ascending order, of the same first edge.
  void Remove(std::vector<Index>* faces) {
    std::sort(faces->begin(), faces->end(), [&](Index a, Index b) {
      const int order = Compare(a, b);
      return order != 0 ? order < 0 : a < b;
    });
    for (std::size_t begin = 0, end = 0; begin < faces->size(); begin = end) {
      while (end < faces->size() && Compare((*faces)[begin], (*faces)[end]) == 0) ++end;
      const auto same = absl::MakeConstSpan(*faces).subspan(begin, end - begin);
      if (same.size() < 2 || (same.size() == 2 && BackToBack(same[0], same[1]))) continue;
      for (const Index f : same.subspan(1)) p_.state[f] = FaceState::kRemoved;
      const auto forwards =
          std::count_if(same.begin(), same.end(), [&](Index f) { return Forwards(f); });
      if (2 * static_cast<std::size_t>(forwards) == same.size()) folded_[same[0]] = 1;
    }
  }

  // Whether two faces of the same vertices are a closed surface by themselves.
  bool BackToBack(Index a, Index b) const {
    if (Forwards(a) == Forwards(b)) return false;
    const auto begin = crowded_.begin();
    return std::find(begin + p_.face_begin[a], begin + p_.face_begin[a + 1], 1) ==
           begin + p_.face_begin[a + 1];
  }

  const Context& context_;
  const EdgeTable& edges_;
  // A face's state is written by the one bucket that its first edge is in.
  Patchwork& p_;
  // Per face.
  Buffer<Index> first_side_;
  // Per side: whether its edge has more than two.
  Buffer<std::uint8_t> crowded_;
  Buffer<std::uint8_t> folded_;
};

}  // namespace

absl::Status RemoveRepeatedFaces(const Context& context, const EdgeTable& edges, bool folds,
                                 Patchwork* patchwork, RepairReport* report) {
  RepeatFinder repeats(context, edges, patchwork);
  LIMN_RETURN_IF_ERROR(repeats.Run());
  report->repeated_faces_removed = static_cast<std::uint64_t>(
      std::count(patchwork->state.begin(), patchwork->state.end(), FaceState::kRemoved));
  if (!folds || report->repeated_faces_removed == 0) return context.Check();
  return RemoveFolds(context, edges, repeats.folded(), patchwork, report);
}

}  // namespace limn::repair
