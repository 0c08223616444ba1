// SPDX-License-Identifier: MIT
#include "engine/limit/primal_surface.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/refine/catmull_clark_refine.h"
#include "engine/refine/quad_split.h"
#include "engine/refine/triangle_split.h"

namespace limn {

absl::StatusOr<PrimalSurface> MakeCatmullClarkSurface(const Context& context,
                                                      const SurfaceLevel& level,
                                                      absl::Span<const Vec3> points,
                                                      double bilinear) {
  LIMN_ASSIGN_OR_RETURN(HalfEdgeMesh split, SplitIntoQuads(context, level.mesh));
  PrimalSurface surface = {.kind = RingKind::kQuads, .mesh = std::move(split)};
  surface.points.resize(surface.mesh.vertex_count());
  LIMN_RETURN_IF_ERROR(
      RefineCatmullClark(context, level, points, absl::MakeSpan(surface.points), bilinear));
  LIMN_ASSIGN_OR_RETURN(surface.sharpness,
                        RefineSharpness(context, level.mesh, surface.mesh, level.sharpness));
  surface.face_begin.assign(level.mesh.face_begin().begin(), level.mesh.face_begin().end());
  return surface;
}

absl::StatusOr<PrimalSurface> MakeLoopSurface(HalfEdgeMesh mesh, Sharpness sharpness,
                                              Buffer<Vec3> points) {
  LIMN_RETURN_IF_ERROR(RequireTriangles(mesh));
  if (points.size() != mesh.vertex_count()) {
    return MakeError(absl::StrCat(points.size(), " points of ", mesh.vertex_count(), " vertices"),
                     {.reason = Reason::kInternal});
  }
  return PrimalSurface{.kind = RingKind::kTriangles,
                       .mesh = std::move(mesh),
                       .sharpness = std::move(sharpness),
                       .points = std::move(points)};
}

}  // namespace limn
