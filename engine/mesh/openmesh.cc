// SPDX-License-Identifier: MIT
// Copies connectivity half-edge by half-edge instead of face by face: nothing to search, and no
// dependence on the order of faces.
#include "engine/mesh/openmesh.h"

#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/mesh/half_edge_mesh.h"
#include "engine/mesh/validate.h"

namespace limn {
namespace {

using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

constexpr std::size_t kMaxEdges = std::size_t{1} << 30;

class Converter {
 public:
  Converter(const PolygonMesh& mesh, const HalfEdgeMesh& half_edges)
      : mesh_(mesh), half_edges_(half_edges), walk_(half_edges) {}

  OpenMeshPolyMesh Convert() {
    result_.reserve(mesh_.vertex_count(), half_edges_.edge_count(), mesh_.face_count());
    for (const Vec3& p : mesh_.positions) {
      // Not add_vertex, which gives out property-aware handles; the kernel's is all that is needed.
      result_.set_point(result_.new_vertex(), OpenMesh::Vec3d(p.x, p.y, p.z));
    }
    AddEdges();
    AddFaces();
    CloseBoundaries();
    return std::move(result_);
  }

 private:
  // OpenMesh pairs its half-edges as 2e and 2e + 1; the even one is the edge's first half-edge.
  HalfedgeHandle Handle(Index h) const {
    const Index edge = half_edges_.edge()[h];
    const bool second = half_edges_.edge_half_edge()[edge] != h;
    return HalfedgeHandle(static_cast<int>(2 * edge + (second ? 1 : 0)));
  }

  void AddEdges() {
    for (const Index h : half_edges_.edge_half_edge()) {
      result_.new_edge(Vertex(half_edges_.vertex()[h]),
                       Vertex(half_edges_.vertex()[walk_.Next(h)]));
    }
  }

  void AddFaces() {
    for (Index f = 0; f < mesh_.face_count(); ++f) {
      const FaceHandle face = result_.new_face();
      for (Index h = walk_.FaceBegin(f); h < walk_.FaceEnd(f); ++h) {
        const HalfedgeHandle handle = Handle(h);
        result_.set_face_handle(handle, face);
        result_.set_next_halfedge_handle(handle, Handle(walk_.Next(h)));
        result_.set_halfedge_handle(Vertex(half_edges_.vertex()[h]), handle);
      }
      // The half-edge into the first corner: where circulators begin.
      result_.set_halfedge_handle(face, Handle(walk_.FaceEnd(f) - 1));
    }
  }

  // Boundary half-edges run the other way round. One leaves each boundary vertex, and OpenMesh
  // wants it to be the vertex' own half-edge.
  void CloseBoundaries() {
    std::vector<Index> boundary;  // half-edges without twin
    for (const Index h : half_edges_.edge_half_edge()) {
      if (half_edges_.twin()[h] == kNoIndex) boundary.push_back(h);
    }
    for (const Index h : boundary) {
      const HalfedgeHandle outside = result_.opposite_halfedge_handle(Handle(h));
      result_.set_halfedge_handle(result_.from_vertex_handle(outside), outside);
    }
    for (const Index h : boundary) {
      const HalfedgeHandle outside = result_.opposite_halfedge_handle(Handle(h));
      result_.set_next_halfedge_handle(outside,
                                       result_.halfedge_handle(result_.to_vertex_handle(outside)));
    }
  }

  static VertexHandle Vertex(Index v) { return VertexHandle(static_cast<int>(v)); }

  const PolygonMesh& mesh_;
  const HalfEdgeMesh& half_edges_;
  PolygonWalk walk_;
  OpenMeshPolyMesh result_;
};

absl::StatusOr<OpenMeshPolyMesh> Convert(const Context& context, const PolygonMesh& mesh) {
  LIMN_ASSIGN_OR_RETURN(const HalfEdgeMesh half_edges, HalfEdgeMesh::Build(context, mesh));
  BoundingBox box;
  LIMN_RETURN_IF_ERROR(ValidatePositions(context, mesh.positions, &box));
  if (half_edges.edge_count() >= kMaxEdges) {
    return MakeError(absl::StrCat("OpenMesh cannot count ", half_edges.edge_count(), " edges"),
                     {.reason = Reason::kLimitExceeded,
                      .field = "faces",
                      .remedy = "Convert the mesh in parts"});
  }
  return Converter(mesh, half_edges).Convert();
}

absl::Status OutOfMemory() {
  return MakeError("no memory to convert the mesh to OpenMesh",
                   {.reason = Reason::kOutOfMemory, .field = "mesh"});
}

}  // namespace

PolygonMesh FromOpenMesh(const OpenMeshPolyMesh& mesh) {
  PolygonMesh result;
  // The iterators of all elements, since those that skip the deleted need their status property.
  const bool some_deleted_vertices = mesh.has_vertex_status();
  const bool some_deleted_faces = mesh.has_face_status();
  Buffer<Index> number(mesh.n_vertices(), kNoIndex);
  result.positions.reserve(mesh.n_vertices());
  for (const auto vertex : mesh.all_vertices()) {
    if (some_deleted_vertices && mesh.status(vertex).deleted()) continue;
    number[static_cast<std::size_t>(vertex.idx())] = static_cast<Index>(result.vertex_count());
    const OpenMesh::Vec3d& point = mesh.point(vertex);
    result.positions.push_back({point[0], point[1], point[2]});
  }
  Buffer<Index> corners;
  for (const auto face : mesh.all_faces()) {
    if (some_deleted_faces && mesh.status(face).deleted()) continue;
    corners.clear();
    for (const auto vertex : mesh.fv_range(face)) {
      corners.push_back(number[static_cast<std::size_t>(vertex.idx())]);
    }
    result.AddFace(corners);
  }
  return result;
}

absl::StatusOr<OpenMeshPolyMesh> ToOpenMesh(const Context& context, const PolygonMesh& mesh) {
  try {
    return Convert(context, mesh);
  } catch (const std::bad_alloc&) {
    return OutOfMemory();
  } catch (const std::length_error&) {
    return OutOfMemory();
  }
}

absl::StatusOr<OpenMeshPolyMesh> ToOpenMesh(const PolygonMesh& mesh) {
  return ToOpenMesh(Context(), mesh);
}

}  // namespace limn
