// SPDX-License-Identifier: MIT
// PolygonMesh to and from OpenMesh, for programs that keep their meshes there. OpenMesh's own
// checks are asserts, so nothing reaches it that is not known to be valid.
#pragma once

// OpenMesh's vectors are uninitialised on purpose, which GCC warns of in sanitizer builds.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/Traits.hh>
#pragma GCC diagnostic pop

#include "absl/status/statusor.h"
#include "engine/base/context.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn {

// Double coordinates; no attributes beyond OpenMesh's own.
struct OpenMeshTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using OpenMeshPolyMesh = OpenMesh::PolyMesh_ArrayKernelT<OpenMeshTraits>;

// Vertices and faces in the mesh's order, each face from the corner where OpenMesh's circulators
// begin. Elements marked as deleted are left out, and the rest counted through. Cost: linear.
// Thread-safe.
[[nodiscard]] PolygonMesh FromOpenMesh(const OpenMeshPolyMesh& mesh);

// The same mesh in OpenMesh: vertex and face i of the one are vertex and face i of the other, faces
// begin at the same corner, positions are the same doubles; FromOpenMesh gives back the same
// arrays. Meshes with boundary, too. Works for every valid mesh, also where OpenMesh's add_face
// would refuse a face because of the order in which faces come.
//
// Errors: as HalfEdgeMesh::Build and ValidatePositions; LIMIT_EXCEEDED from 2^30 edges, as OpenMesh
// counts with int; OUT_OF_MEMORY. Cost: linear. Thread-safe.
[[nodiscard]] absl::StatusOr<OpenMeshPolyMesh> ToOpenMesh(const Context& context,
                                                          const PolygonMesh& mesh);
[[nodiscard]] absl::StatusOr<OpenMeshPolyMesh> ToOpenMesh(const PolygonMesh& mesh);

}  // namespace limn
