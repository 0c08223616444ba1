// SPDX-License-Identifier: MIT
// What the writers see of a mesh or a tessellation, and its triangles.
#pragma once

#include <cstddef>
#include <string_view>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "client/io/output_file.h"
#include "engine/base/vec3.h"
#include "engine/limit/tessellation.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::io {

struct SurfaceView {
  absl::Span<const Vec3> positions;
  absl::Span<const Vec3> normals;  // empty, or one per position
  Index arity = 0;                 // of all faces, or 0: see face_begin
  absl::Span<const Index> face_begin;
  absl::Span<const Index> vertices;

  explicit SurfaceView(const PolygonMesh& mesh)
      : positions(mesh.positions), face_begin(mesh.face_begin), vertices(mesh.corner_vertex) {}
  explicit SurfaceView(const Tessellation& surface)
      : positions(surface.positions),
        normals(surface.normals),
        arity(surface.arity),
        face_begin(surface.face_begin),
        vertices(surface.face_vertices) {}

  std::size_t face_count() const {
    if (arity != 0) return vertices.size() / arity;
    return face_begin.empty() ? 0 : face_begin.size() - 1;
  }
  absl::Span<const Index> face(std::size_t f) const {
    if (arity != 0) return vertices.subspan(f * arity, arity);
    return vertices.subspan(face_begin[f], face_begin[f + 1] - face_begin[f]);
  }

  // Triangles that ForEachTriangle visits.
  std::size_t triangle_count() const {
    std::size_t count = 0;
    for (std::size_t f = 0; f < face_count(); ++f) {
      if (face(f).size() >= 3) count += face(f).size() - 2;
    }
    return count;
  }

  // Calls visit(a, b, c) for triangles that make up all faces: quads are cut along their shorter
  // diagonal, other faces into fans; faces without area (fewer than three corners) are left out.
  template <class Visit>
  void ForEachTriangle(const Visit& visit) const {
    for (std::size_t f = 0; f < face_count(); ++f) {
      const absl::Span<const Index> v = face(f);
      if (v.size() == 4 && SecondDiagonalIsShorter(v)) {
        visit(v[0], v[1], v[3]);
        visit(v[1], v[2], v[3]);
        continue;
      }
      for (std::size_t i = 2; i < v.size(); ++i) visit(v[0], v[i - 1], v[i]);
    }
  }

 private:
  bool SecondDiagonalIsShorter(absl::Span<const Index> v) const {
    const Vec3 first = positions[v[2]] - positions[v[0]];
    const Vec3 second = positions[v[3]] - positions[v[1]];
    return Dot(second, second) < Dot(first, first);
  }
};

// The formats. `file` gets the content; what goes wrong with the file itself is told by Commit.
absl::Status WriteObj(const SurfaceView& view, OutputFile* file);
absl::Status WriteOff(const SurfaceView& view, OutputFile* file);
absl::Status WritePly(const SurfaceView& view, OutputFile* file);
absl::Status WriteStl(const SurfaceView& view, OutputFile* file);
absl::Status WriteGlb(const SurfaceView& view, OutputFile* file);

// Whether all points are finite and, relative to `origin`, within the range of float32. Errors:
// NON_FINITE_COORDINATE, COORDINATE_TOO_LARGE with the vertex.
absl::Status CheckFloat32(const SurfaceView& view, const Vec3& origin, std::string_view format);

}  // namespace limn::io
