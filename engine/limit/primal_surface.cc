// SPDX-License-Identifier: MIT
#include "engine/limit/primal_surface.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/mesh/quad_split.h"
#include "engine/mesh/triangle_split.h"
#include "engine/refine/catmull_clark_refine.h"

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

Index FindPatch(const PrimalSurface& surface, const SurfaceParameter& parameter,
                PatchPlace* place) {
  const bool quads = surface.kind == RingKind::kQuads;
  const auto sides = static_cast<Index>(quads ? 4 : 3);
  *place = {.kind = surface.kind, .u = parameter.u, .v = parameter.v};
  Index h = quads ? 4 * (surface.face_begin[parameter.face] + parameter.corner)
                  : 3 * parameter.face + parameter.corner;
  for (std::uint32_t k = 0; k < surface.depth; ++k) {
    const auto near = static_cast<Index>(place->CornerNear());
    place->EnterChild();
    if (near == sides) {
      // The middle triangle.
      h = 3 * (4 * (h / 3) + 3) + h % 3;
      continue;
    }
    const Index first = h - h % sides;
    h = first + (h % sides + near) % sides;
    h = quads ? 4 * h : 3 * CornerTriangle(h);
  }
  return h;
}

}  // namespace limn
