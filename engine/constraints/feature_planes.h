// SPDX-License-Identifier: MIT
// The planes of plane faces, into which their vertices are moved. Source: none; Xu and Kondo,
// section 3.2.2, take plane faces for planar.
#pragma once

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/base/vec3.h"
#include "engine/constraints/feature_values.h"
#include "engine/mesh/half_edge_mesh.h"

namespace limn {

// The given points, relative to an origin, and the diagonal of their bounding box (not 0).
struct PlanePoints {
  absl::Span<const Vec3> points;
  double scale = 1;
  // What the table was made of: errors name the entry of a face then, else the list.
  const FeatureValues* values = nullptr;
};

// Points with which all plane faces are planar: empty when they are as given, each corner within
// 1e-13 of the diagonal of its face's plane. Else vertices of plane faces that are not in all the
// planes around them are moved there by the shortest way; the others stay as they are, to the bit.
// A face's plane is that through its mean along its average normal [ZC Eq. 10]. Triangles are
// planar wherever their vertices are, and move none.
//
// Faces that meet at a vertex at less than 1e-3 rad, and the neighbours of these, count as one
// plane where one of them is not planar, such as those of a plane that was cut up and rounded: that
// through their mean along their mean normal, weighted by area. Where small turns add up to more
// than 1e-3 rad from the mean, as around a fine cylinder, each keeps its own.
//
// Errors, INVALID_OPTION: a face whose corners lie on a line; a vertex whose planes do not meet in
// a point within 2e-13 of the diagonal, or nearly not (a further plane counts from an angle of 1e-3
// on), or only further away than an eighth of its shortest edge. Edges without length, not above
// 1e-13 of the diagonal, do not count there; a vertex without any other is not moved. The message
// names the first such face, or else vertex; the field is the kind of the face's entry,
// "constraints.features.faces[3].kind", with its index, or "constraints.features.default_face"; for
// a vertex, that of the least plane face around it. CANCELLED, DEADLINE_EXCEEDED. Cost: a few
// passes over the corners. Same result for any number of threads. Thread-safe.
[[nodiscard]] absl::StatusOr<Buffer<Vec3>> FlattenPlaneFaces(const Context& context,
                                                             const HalfEdgeMesh& mesh,
                                                             const FeatureTable& table,
                                                             const PlanePoints& given);

}  // namespace limn
