// SPDX-License-Identifier: MIT
#include "tests/oracle/tessellations.h"

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/limit/doo_sabin_limit.h"
#include "engine/mesh/quad_split.h"
#include "engine/refine/doo_sabin_refine.h"

namespace limn::oracle {
namespace {

void OrThrow(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(std::string(status.message()));
}
template <class T>
T OrThrow(absl::StatusOr<T> value) {
  OrThrow(value.status());
  return *std::move(value);
}

// The faces and vertices of T^0.
Tessellation GivenFaces(const DooSabinSurface& surface, const ExtraordinaryFans& fans) {
  const HalfEdgeMesh& mesh = surface.mesh;
  Tessellation result;
  result.positions.resize(mesh.vertex_count());
  OrThrow(DooSabinLimit(
      Context(), {.mesh = mesh, .fans = fans, .k = 1, .boundary = &surface.boundary},
      surface.corners,
      {.points = absl::MakeSpan(result.positions), .normals = {}, .vertices_only = true}));
  result.face_begin.assign(mesh.face_begin().begin(), mesh.face_begin().end());
  result.face_vertices.assign(mesh.vertex().begin(), mesh.vertex().end());
  return result;
}

}  // namespace

std::vector<Tessellation> TessellationsOf(const DooSabinSurface& surface, int finest) {
  const Context context;
  const ExtraordinaryFans fans = OrThrow(FindExtraordinaryFans(context, surface.mesh));
  std::vector<Tessellation> levels = {GivenFaces(surface, fans)};
  DooSabinSurface at = surface;
  for (int k = 1; k <= finest; ++k) {
    const auto level = static_cast<std::uint32_t>(k);
    if (k > 1) {
      Buffer<Vec3> refined(4 * at.corners.size());
      OrThrow(RefineDooSabin(
          context, {.mesh = at.mesh, .fans = fans, .k = level - 1, .boundary = &at.boundary},
          at.corners, absl::MakeSpan(refined)));
      at.corners = std::move(refined);
      at.boundary = OrThrow(RefineBoundary(context, at.mesh, at.boundary));
      at.mesh = OrThrow(SplitIntoQuads(context, at.mesh));
    }
    Tessellation fine;
    fine.level = level;
    fine.arity = 4;
    fine.positions.resize(at.mesh.vertex_count() + at.mesh.edge_count() + at.mesh.face_count());
    OrThrow(DooSabinLimit(context,
                          {.mesh = at.mesh, .fans = fans, .k = level, .boundary = &at.boundary},
                          at.corners, {.points = absl::MakeSpan(fine.positions), .normals = {}}));
    fine.face_vertices.resize(4 * at.mesh.half_edge_count());
    OrThrow(QuadVertices(context, at.mesh, absl::MakeSpan(fine.face_vertices)));
    levels.push_back(std::move(fine));
  }
  return levels;
}

std::vector<Triangle> SplitAtRandom(const Tessellation& surface, std::mt19937_64* random) {
  std::vector<Triangle> triangles;
  for (std::size_t f = 0; f < surface.face_count(); ++f) {
    const std::size_t begin = surface.arity != 0 ? surface.arity * f : surface.face_begin[f];
    const std::size_t end = surface.arity != 0 ? begin + surface.arity : surface.face_begin[f + 1];
    const std::size_t m = end - begin;
    const std::size_t start = (*random)() % m;
    const auto point = [&](std::size_t i) {
      return surface.positions[surface.face_vertices[begin + (start + i) % m]];
    };
    for (std::size_t i = 1; i + 1 < m; ++i) {
      triangles.push_back({point(0), point(i), point(i + 1)});
    }
  }
  return triangles;
}

}  // namespace limn::oracle
