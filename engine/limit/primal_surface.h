// SPDX-License-Identifier: MIT
// A Catmull-Clark or Loop surface, held by the level from which on its own rules hold for one kind
// of face: all that exact evaluation starts from.
#pragma once

#include <cstddef>
#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/limit/limit_masks.h"
#include "engine/limit/patch_place.h"
#include "engine/limit/surface_parameter.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/scheme/sharpness.h"

namespace limn {

struct PrimalSurface {
  RingKind kind = RingKind::kQuads;
  // Quads: T^(depth + 1); the quads 4^depth h to 4^depth (h + 1) - 1 are the patch of the corner h
  // of T^0. Triangles: T^depth, likewise of the face h.
  HalfEdgeMesh mesh;
  // Of that level.
  Sharpness sharpness = {};
  Buffer<Vec3> points = {};
  // Quads: first corner of each face of T^0, and at the end their number. Triangles: empty.
  Buffer<Index> face_begin = {};
  // At extraordinary points tangents are those of the mesh, times 2^depth.
  std::uint32_t depth = 0;
  // Added to points.
  Vec3 origin = {0, 0, 0};

  // Of T^0.
  std::size_t face_count() const {
    return kind == RingKind::kQuads ? face_begin.size() - 1 : mesh.face_count() >> (2 * depth);
  }
  std::size_t arity(Index face) const {
    return kind == RingKind::kQuads ? face_begin[face + 1] - face_begin[face] : 3;
  }
};

// The surface of a control mesh. mesh: T^0, from HalfEdgeMesh::Build. points: its control points,
// relative to origin. bilinear: of the first refinement, see RefineCatmullClark.
// Errors: as SplitIntoQuads and RefineCatmullClark. Cost: one refinement.
[[nodiscard]] absl::StatusOr<PrimalSurface> MakeCatmullClarkSurface(const Context& context,
                                                                    const SurfaceLevel& level,
                                                                    absl::Span<const Vec3> points,
                                                                    double bilinear = 0);

// The same for Loop. mesh: from Build; it and its sharpness are taken. Errors: as RequireTriangles;
// INTERNAL when sizes do not fit. Cost: of the check.
[[nodiscard]] absl::StatusOr<PrimalSurface> MakeLoopSurface(HalfEdgeMesh mesh, Sharpness sharpness,
                                                            Buffer<Vec3> points);

// The face of the surface's mesh that a valid parameter is in: returns the half-edge that leaves
// the first corner of the patch, in which the parameter is at *place. Cost: of the depth.
// Thread-safe.
[[nodiscard]] Index FindPatch(const PrimalSurface& surface, const SurfaceParameter& parameter,
                              PatchPlace* place);

}  // namespace limn
