// SPDX-License-Identifier: MIT
// Doo-Sabin patches for evaluation; engine/limit/ring_patch.h has the method.
#include <utility>

#include "engine/base/error.h"
#include "engine/limit/control_ring.h"
#include "engine/limit/patch_source.h"
#include "engine/limit/ring_patch.h"

namespace limn {
namespace {

// The boundary curve from a vertex to the middle of an edge: a quadratic Bezier curve. Its end is
// summed alike from both sides of the edge.
Vec3 HalfEdgeCurve(const Vec3& vertex, const Vec3& near, const Vec3& far, double t) {
  const double s = 1 - t;
  return s * s * vertex + 2 * s * t * near + t * t * (0.5 * (near + far));
}

// The point in the model's frame.
Vec3 PointAt(const DooSabinSurface& surface, Index h, const SurfaceParameter& p,
             const Vec3& local) {
  const BoundaryCurve& curve = surface.boundary;
  if (p.v == 0 && surface.mesh.twin()[h] == kNoIndex) {
    const Index i = curve.Find(h);
    return HalfEdgeCurve(curve.centre[i], curve.start[i], curve.end[i], p.u);
  }
  if (p.u == 0) {
    const Index prev = PolygonWalk(surface.mesh).Prev(h);
    if (surface.mesh.twin()[prev] == kNoIndex) {
      const Index i = curve.Find(prev);
      return HalfEdgeCurve(curve.centre[curve.next[i]], curve.end[i], curve.start[i], p.v);
    }
  }
  return local + curve.origin;
}

class DooSabinPatches : public PatchSource {
 public:
  DooSabinPatches(const DooSabinSurface& surface, LargeFaces large_faces)
      : surface_(surface), large_faces_(std::move(large_faces)) {}

  std::size_t face_count() const override { return surface_.mesh.face_count(); }
  std::size_t arity(Index face) const override {
    return surface_.mesh.face_begin()[face + 1] - surface_.mesh.face_begin()[face];
  }
  bool triangles() const override { return false; }

  void Evaluate(const Context& /*context*/, absl::Span<const SurfaceParameter> parameters,
                const SurfaceSamples& samples,
                std::pair<std::size_t, std::size_t> range) const override {
    RingGatherer gatherer(surface_, large_faces_);
    for (std::size_t i = range.first; i < range.second; ++i) {
      const SurfaceParameter& p = parameters[i];
      const Index h = surface_.mesh.face_begin()[p.face] + p.corner;
      PatchSample sample = EvaluateRing(gatherer.Gather(h), p.u, p.v);
      sample.point = PointAt(surface_, h, p, sample.point);
      WriteSample(sample, i, samples);
    }
  }

 private:
  const DooSabinSurface& surface_;
  const LargeFaces large_faces_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<PatchSource>> MakeDooSabinPatches(const Context& context,
                                                                 const DooSabinSurface& surface) {
  LIMN_ASSIGN_OR_RETURN(LargeFaces large_faces, LargeFaces::Find(context, surface));
  return std::make_unique<DooSabinPatches>(surface, std::move(large_faces));
}

}  // namespace limn
