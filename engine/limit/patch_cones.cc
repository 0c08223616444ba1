// SPDX-License-Identifier: MIT
#include "engine/limit/patch_cones.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine/base/error.h"
#include "engine/base/parallel.h"

namespace limn {
namespace {

// Adds what is known about another normal. `stretch` is turned by the whole angle in the end.
void Include(const ProjectedCone& other, ProjectedCone* cone) {
  cone->angle = std::max(cone->angle, AngleBetween(cone->normal, other.normal) + other.angle);
  cone->stretch = std::min(cone->stretch, other.stretch);
}

// A deviation by another normal: its height may change by that part of its length, and its slide
// may be all of it.
Deviation Turned(const Deviation& deviation, const Vec3& from, const Vec3& to) {
  const double length = deviation.length();
  return {std::min(length, deviation.height + Norm(from - to) * length), length};
}

}  // namespace

absl::StatusOr<PatchCones> PatchCones::Make(const Context& context, const HalfEdgeMesh& mesh,
                                            absl::Span<const PatchBound> patches) {
  PatchCones cones(mesh, patches);
  LIMN_RETURN_IF_ERROR(WithWalk(mesh, [&](auto walk) { return cones.Join(context, walk); }));
  return cones;
}

// for_corners(f): calls f for each corner of the face of M^k.
template <class ForCorners>
PatchCones::Joint PatchCones::JointOf(bool at_boundary, const ForCorners& for_corners) const {
  Vec3 sum = {0, 0, 0};
  for_corners([&](Index h) { sum += patches_[h].cone.normal; });
  Joint joint = {.cone = {.normal = NormalizedOrZero(sum),
                          .angle = 0,
                          .stretch = std::numeric_limits<double>::infinity()},
                 .deviation = {},
                 .at_boundary = at_boundary};
  for_corners([&](Index h) {
    const PatchBound& patch = patches_[h];
    Include(patch.cone, &joint.cone);
    joint.deviation.Widen(Turned(patch.deviation, patch.cone.normal, joint.cone.normal));
  });
  return joint;
}

template <class Walk>
absl::Status PatchCones::Join(const Context& context, const Walk& walk) {
  const absl::Span<const Index> twin = mesh_.twin();
  const std::size_t vertices = mesh_.vertex_count();
  const std::size_t edges = mesh_.edge_count();
  joints_.resize(vertices + edges + mesh_.face_count());
  LIMN_RETURN_IF_ERROR(ParallelFor(context, vertices, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Index start = mesh_.vertex_half_edge()[v];
      joints_[v] = JointOf(twin[start] == kNoIndex, [&](const auto& f) {
        Index h = start;
        do {
          f(h);
          h = RotateCcw(walk, twin, h);
        } while (h != start && h != kNoIndex);
      });
    }
  }));
  LIMN_RETURN_IF_ERROR(ParallelFor(context, edges, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const Index h = mesh_.edge_half_edge()[e];
      joints_[vertices + e] = JointOf(twin[h] == kNoIndex, [&](const auto& f) {
        f(h);
        f(walk.Next(h));
        if (twin[h] == kNoIndex) return;
        f(twin[h]);
        f(walk.Next(twin[h]));
      });
    }
  }));
  return ParallelFor(context, mesh_.face_count(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Index face = static_cast<Index>(i);
      joints_[vertices + edges + i] = JointOf(false, [&](const auto& f) {
        for (Index h = walk.FaceBegin(face); h < walk.FaceEnd(face); ++h) f(h);
      });
    }
  });
}

PatchCones::Surroundings PatchCones::Around(Index h) const {
  const std::size_t vertices = mesh_.vertex_count();
  const std::size_t edges = mesh_.edge_count();
  Surroundings around = {.cone = patches_[h].cone, .deviation = patches_[h].deviation};
  const std::array<std::size_t, 4> corners = WithWalk(mesh_, [&](auto walk) {
    return std::array<std::size_t, 4>{mesh_.vertex()[h], vertices + mesh_.edge()[h],
                                      vertices + mesh_.edge()[walk.Prev(h)],
                                      vertices + edges + walk.Face(h)};
  });
  for (const std::size_t corner : corners) {
    Include(joints_[corner].cone, &around.cone);
    around.at_boundary = around.at_boundary || joints_[corner].at_boundary;
  }
  if (!around.at_boundary) return around;
  for (const std::size_t corner : corners) {
    const Joint& joint = joints_[corner];
    around.deviation.Widen(Turned(joint.deviation, joint.cone.normal, around.cone.normal));
  }
  return around;
}

}  // namespace limn
