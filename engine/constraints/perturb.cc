// SPDX-License-Identifier: MIT
#include "engine/constraints/perturb.h"

#include "engine/base/parallel.h"

namespace limn {
namespace {

void PerturbFace(absl::Span<const Index> fan, const Vec3& target, absl::Span<Vec3> corners) {
  const Vec3 origin = corners[fan[0]];
  Vec3 sum = {0, 0, 0};
  for (const Index h : fan.subspan(1)) sum += corners[h] - origin;
  const Vec3 centroid = origin + (1.0 / static_cast<double>(fan.size())) * sum;
  const Vec3 normal =
      AverageNormal(fan.size(), centroid, [&](std::size_t i) { return corners[fan[i]]; });
  for (const Index h : fan) {
    // [ZC Eq. 17] as the target plus what remains of the offset in the plane: the rounding of
    // W + (target - centroid) never enters.
    const Vec3 offset = corners[h] - centroid;
    corners[h] = target + (offset - Dot(offset, normal) * normal);
  }
}

}  // namespace

absl::Status PerturbToInterpolate(const Context& context, const HalfEdgeMesh& mesh,
                                  absl::Span<const Vec3> points, absl::Span<Vec3> corners) {
  return ParallelFor(context, mesh.vertex_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      PerturbFace(mesh.fan().subspan(mesh.fan_begin()[v], mesh.valence(v)), points[v], corners);
    }
  });
}

}  // namespace limn
