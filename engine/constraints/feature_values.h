// SPDX-License-Identifier: MIT
// Feature values: the numbers by which faces, edges and vertices of a rough polyhedron say how
// round, sharp or flat its Doo-Sabin surface is there. What they mean for the points of the surface
// is in engine/constraints/features.h. Source: Xu and Kondo, "Introducing feature values for
// effective specification of polyhedral networks", section 3.1.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "engine/base/buffer.h"
#include "engine/base/context.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// What a face becomes: FFV 0 and 1.
enum class FaceKind : std::uint8_t { kPlane, kSurface };

struct FaceFeature {
  Index face = 0;
  FaceKind kind = FaceKind::kSurface;
};

// EFV of an edge, in [0, 1]: how far the surface is rounded along it. 0 is sharp.
struct EdgeFeature {
  // Its ends, in either order.
  Index from = 0;
  Index to = 0;
  // Only in this face; absent: in both.
  std::optional<Index> face = std::nullopt;
  double value = 0.5;
};

// VFV of a vertex, in [0, 1]. 0 is sharp: the surface passes through the vertex.
struct VertexFeature {
  Index vertex = 0;
  // Only in this face; absent: in all around it.
  std::optional<Index> face = std::nullopt;
  double value = 1;
};

// The value of an element in a face is that of the entry which names both, else that of the entry
// which names the element, else the default, whatever the order of the lists. With the defaults the
// images of planar faces are those of the modified first step [ZC Eq. 4].
struct FeatureValues {
  FaceKind default_face = FaceKind::kSurface;
  // In [0, 1].
  double default_edge = 0.5;
  double default_vertex = 1;
  // Each face at most once.
  std::vector<FaceFeature> faces;
  // Each edge, and each edge in a face, at most once.
  std::vector<EdgeFeature> edges;
  // Likewise.
  std::vector<VertexFeature> vertices;

  // Whether a face may be plane.
  bool has_planes() const;
  // Whether there is more than defaults.
  bool names_elements() const { return !(faces.empty() && edges.empty() && vertices.empty()); }
};

// Feature values by corner of a mesh: h is the half-edge that leaves the corner's vertex in its
// face.
struct FeatureTable {
  // EFV of the edge of h in the face of h.
  Buffer<double> edge;
  // VFV of the vertex of h in the face of h.
  Buffer<double> vertex;
  // 1 for plane faces; empty if there are none.
  Buffer<std::uint8_t> plane;

  bool IsPlane(std::size_t face) const { return !plane.empty() && plane[face] != 0; }
};

// mesh: from HalfEdgeMesh::Build. Errors, each with the field's path in the contract's words, such
// as "constraints.features.edges[3].value", and its index: INDEX_OUT_OF_RANGE for vertices and
// faces that are not there; INVALID_OPTION for values outside [0, 1] or not numbers, for ends that
// no edge joins, for a face that has not that edge or vertex, for an element that is named twice;
// CANCELLED, DEADLINE_EXCEEDED. Cost: linear in the corners; entries with an edge look through the
// fan of the end with fewer faces. 17 bytes a corner. Thread-safe.
[[nodiscard]] absl::StatusOr<FeatureTable> MakeFeatureTable(const Context& context,
                                                            const HalfEdgeMesh& mesh,
                                                            const FeatureValues& values);

}  // namespace limn
