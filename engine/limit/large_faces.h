// SPDX-License-Identifier: MIT
// The faces of M^1 with so many sides that summing over them for each evaluation would be slow, on
// a hub even quadratic; their harmonics are found once.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/refine/doo_sabin_surface.h"
#include "engine/refine/harmonics.h"

namespace limn {

class LargeFaces {
 public:
  // Sides from which on a face is large: where kUnitAngles ends.
  static constexpr std::size_t kLarge = 32;

  // Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: a pass over vertices and faces, and over the
  // corners of the large ones; at most 8 bytes a corner of these. Same bits for any number of
  // threads.
  [[nodiscard]] static absl::StatusOr<LargeFaces> Find(const Context& context,
                                                       const DooSabinSurface& surface);

  // Harmonics of the type-V face of vertex v in the order of its fan, ghosts last, and of the
  // type-F face of face f. Null for small ones. Cost: logarithmic.
  const Harmonics* OfVertex(std::size_t v) const { return Of(v); }
  const Harmonics* OfFace(std::size_t f) const { return Of(vertex_count_ + f); }

  // Place of half-edge h in the fan of its vertex, which must be a large one. Cost: logarithmic.
  std::size_t PlaceInFan(Index h) const;

 private:
  const Harmonics* Of(std::size_t id) const;

  std::size_t vertex_count_ = 0;
  // Vertices, then faces, ascending, and their harmonics.
  std::vector<std::size_t> id_;
  std::vector<Harmonics> harmonics_;
  // Half-edges in large fans, ascending, with their places.
  std::vector<std::pair<Index, Index>> place_;
};

}  // namespace limn
