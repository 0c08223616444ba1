// SPDX-License-Identifier: MIT
// Catmull-Clark and Loop patches for evaluation; engine/limit/primal_patch.h has the method.
#include <cmath>

#include "engine/limit/gather_ring.h"
#include "engine/limit/patch_source.h"
#include "engine/limit/primal_patch.h"
#include "engine/limit/primal_surface.h"

namespace limn {
namespace {

// Points of rings after which the context is asked whether to go on: about a millisecond.
constexpr std::size_t kWorkPerCheck = 100'000;

template <class Walk, RingKind kKind>
class PrimalPatches : public PatchSource {
 public:
  explicit PrimalPatches(const PrimalSurface& surface)
      : surface_(surface),
        level_({surface.mesh, surface.sharpness}, surface.points),
        walk_(surface.mesh),
        speed_(std::ldexp(1.0, static_cast<int>(surface.depth))) {}

  std::size_t face_count() const override { return surface_.face_count(); }
  std::size_t arity(Index face) const override { return surface_.arity(face); }
  bool triangles() const override { return kKind == RingKind::kTriangles; }

  void Evaluate(const Context& context, absl::Span<const SurfaceParameter> parameters,
                const SurfaceSamples& samples,
                std::pair<std::size_t, std::size_t> range) const override {
    PrimalPatch patch(kKind);
    std::size_t work = 0;
    for (std::size_t i = range.first; i < range.second; ++i) {
      PatchPlace place;
      work += Gather(FindPatch(surface_, parameters[i], &place), &patch);
      const PatchSample sample = patch.Evaluate(place.u, place.v);
      const Vec3 du = speed_ * sample.du;
      const Vec3 dv = speed_ * sample.dv;
      WriteSample({.point = sample.point + surface_.origin,
                   .du = place.turn.U(du, dv),
                   .dv = place.turn.V(du, dv),
                   .normal = sample.normal},
                  i, samples);
      work += patch.work();
      if (work < kWorkPerCheck) continue;
      work = 0;
      if (context.stop_requested()) return;
    }
  }

 private:
  // Returns the number of points of the rings.
  std::size_t Gather(Index h, PrimalPatch* patch) const {
    const auto across = [this](Index leaving) {
      return level_.in[level_.mesh.vertex()[walk_.Next(walk_.Next(leaving))]];
    };
    std::size_t points = 0;
    for (std::size_t i = 0; i < patch->sides(); ++i) {
      PatchCorner& corner = patch->corner(i);
      corner.face = GatherRing<kKind>(level_, walk_, h, across, &corner.ring);
      points += corner.ring.edge.size();
      h = walk_.Next(h);
    }
    return points;
  }

  const PrimalSurface& surface_;
  const LevelPoints level_;
  const Walk walk_;
  // Of a patch of T^0 against those of the mesh.
  const double speed_;
};

}  // namespace

std::unique_ptr<PatchSource> MakePrimalPatches(const PrimalSurface& surface) {
  if (surface.kind == RingKind::kTriangles) {
    return std::make_unique<PrimalPatches<TriangleWalk, RingKind::kTriangles>>(surface);
  }
  return std::make_unique<PrimalPatches<QuadWalk, RingKind::kQuads>>(surface);
}

}  // namespace limn
