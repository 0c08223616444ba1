// SPDX-License-Identifier: MIT
// The cones of patches, and of all patches around each. Used by engine/limit/chord_bound.h.
#pragma once

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/limit/net_deviation.h"
#include "engine/limit/projected_cone.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// A patch of M^k: one per corner of T^(k-1).
struct PatchBound {
  ProjectedCone cone;
  Deviation deviation;
};

class PatchCones {
 public:
  struct Surroundings {
    // About the patch's normal, of it and all patches that share a vertex of T^k with it.
    ProjectedCone cone;
    // Of the patch; where it touches the boundary, of all these.
    Deviation deviation;
    bool at_boundary = false;
  };

  // mesh: T^(k-1); patches: one per half-edge. Both must outlive this. Errors: CANCELLED,
  // DEADLINE_EXCEEDED. Cost: a pass over corners; 64 bytes per vertex of T^k.
  [[nodiscard]] static absl::StatusOr<PatchCones> Make(const Context& context,
                                                       const HalfEdgeMesh& mesh,
                                                       absl::Span<const PatchBound> patches);

  // The patch of corner h and what is around it. Thread-safe.
  Surroundings Around(Index h) const;

 private:
  // Of the patches around a vertex of T^k, about a normal there.
  using Joint = Surroundings;

  PatchCones(const HalfEdgeMesh& mesh, absl::Span<const PatchBound> patches)
      : mesh_(mesh), patches_(patches) {}
  template <class Walk>
  absl::Status Join(const Context& context, const Walk& walk);
  template <class ForCorners>
  Joint JointOf(bool at_boundary, const ForCorners& for_corners) const;

  const HalfEdgeMesh& mesh_;
  absl::Span<const PatchBound> patches_;
  // Numbered as T^k's vertices.
  Buffer<Joint> joints_;
};

}  // namespace limn
