// SPDX-License-Identifier: MIT
// The type-V faces of M^1 as fairing sees them: what of each may move, and how it is put back into
// its place. Used by engine/constraints/fair.h.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/vertex_plan.h"
#include "engine/refine/doo_sabin_surface.h"

namespace limn {

// What of a face may change.
enum class FaceFreedom : std::uint8_t {
  kFixed,  // nothing
  kLoose,  // everything but its centroid
  kPlane,  // it stays in some plane
  kGiven,  // it stays in the plane of the prescribed normal
};

class FairFaces {
 public:
  // surface and plan must outlive this. Errors: CANCELLED, DEADLINE_EXCEEDED. Cost: one pass.
  [[nodiscard]] static absl::StatusOr<FairFaces> Make(const Context& context,
                                                      const DooSabinSurface& surface,
                                                      const VertexPlan& plan);

  std::size_t vertex_count() const { return centre_.size(); }
  absl::Span<const Index> Fan(std::size_t v) const {
    return mesh_.fan().subspan(mesh_.fan_begin()[v], mesh_.valence(v));
  }
  bool AtBoundary(std::size_t v) const { return mesh_.twin()[Fan(v)[0]] == kNoIndex; }
  FaceFreedom freedom(std::size_t v) const { return freedom_[v]; }
  // The limit point at the vertex: the face's centroid.
  const Vec3& centre(std::size_t v) const { return centre_[v]; }
  const HalfEdgeMesh& mesh() const { return mesh_; }
  const BoundaryCurve& boundary() const { return boundary_; }

  // Takes out of a change of all corners what may not change: fixed faces, the mean of each face,
  // what leaves prescribed planes. An orthogonal projection; works on one vertex.
  void Project(std::size_t v, absl::Span<Vec3> change) const;

  // Scales every face about its centroid by the handle min(1, extent / largest extent).
  [[nodiscard]] absl::Status ApplyHandles(const Context& context, double extent,
                                          absl::Span<Vec3> corners) const;

  // Puts moved faces back: the centroid to its place, and the points into the face's plane.
  [[nodiscard]] absl::Status Settle(const Context& context, absl::Span<Vec3> corners) const;

 private:
  FairFaces(const DooSabinSurface& surface, const VertexPlan& plan)
      : mesh_(surface.mesh), boundary_(surface.boundary), plan_(plan) {}
  absl::Status Place(const Context& context, absl::Span<const Vec3> corners);
  FaceFreedom FreedomOf(std::size_t v) const;
  // The handle for offsets from the centroid, or from the boundary's curve.
  template <class Offset>
  double Handle(std::size_t v, double extent, const Offset& offset) const;
  void HandleInterior(std::size_t v, double extent, absl::Span<Vec3> corners) const;
  void HandleBoundary(Index i, double extent, absl::Span<Vec3> corners, BoundaryFace* face) const;
  void SettleInterior(std::size_t v, absl::Span<Vec3> corners) const;
  void SettleBoundary(Index i, absl::Span<Vec3> corners, BoundaryFace* face) const;

  const HalfEdgeMesh& mesh_;
  const BoundaryCurve& boundary_;
  const VertexPlan& plan_;
  Buffer<Vec3> centre_;
  Buffer<FaceFreedom> freedom_;
};

}  // namespace limn
