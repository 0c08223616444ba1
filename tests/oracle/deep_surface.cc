// SPDX-License-Identifier: MIT
#include "tests/oracle/deep_surface.h"

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "engine/interpolate.h"
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

DooSabinSurface SurfaceOf(const PolygonMesh& given) {
  DooSabinSurface surface = {.mesh = OrThrow(HalfEdgeMesh::Build(Context(), given))};
  surface.corners.resize(surface.mesh.half_edge_count());
  surface.boundary = OrThrow(FindBoundary(Context(), surface.mesh));
  for (Buffer<Vec3>* points :
       {&surface.boundary.centre, &surface.boundary.start, &surface.boundary.end}) {
    points->resize(surface.boundary.size());
  }
  return surface;
}

using GridPoint = std::pair<std::size_t, std::size_t>;

// Places on the grid of the corners of every quad of T^level.
std::vector<std::array<GridPoint, 4>> QuadPlaces(std::size_t half_edges, std::uint32_t level) {
  const std::size_t cells = std::size_t{1} << (level - 1);
  std::vector<std::array<GridPoint, 4>> quads(
      half_edges,
      std::array<GridPoint, 4>{GridPoint{0, 0}, {cells, 0}, {cells, cells}, {0, cells}});
  const auto middle = [](const GridPoint& a, const GridPoint& b) {
    return GridPoint{(a.first + b.first) / 2, (a.second + b.second) / 2};
  };
  for (std::uint32_t k = 1; k < level; ++k) {
    std::vector<std::array<GridPoint, 4>> finer;
    for (const auto& q : quads) {
      for (std::size_t j = 0; j < 4; ++j) {
        const std::size_t next = (j + 1) % 4;
        const std::size_t prev = (j + 3) % 4;
        finer.push_back({q[j], middle(q[j], q[next]), middle(q[0], q[2]), middle(q[prev], q[j])});
      }
    }
    quads = std::move(finer);
  }
  return quads;
}

}  // namespace

DooSabinSurface RandomSurface(const PolygonMesh& given, std::uint64_t seed) {
  DooSabinSurface surface = SurfaceOf(given);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto point = [&] {
    const double x = coordinate(random);
    const double y = coordinate(random);
    return Vec3{x, y, coordinate(random)};
  };
  for (Vec3& p : surface.corners) p = point();
  BoundaryCurve& curve = surface.boundary;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    curve.start[i] = point();
    curve.end[i] = point();
  }
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const bool corner = surface.mesh.valence(surface.mesh.vertex()[curve.half_edge[i]]) == 1;
    curve.centre[i] = corner ? point() : 0.5 * (curve.start[i] + curve.end[curve.previous[i]]);
  }
  return surface;
}

DooSabinSurface RandomSharpSurface(const PolygonMesh& given, std::uint64_t seed) {
  DooSabinSurface surface = RandomSurface(given, seed);
  std::mt19937_64 random(seed + 1);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  BoundaryCurve& curve = surface.boundary;
  curve.sharp.assign(curve.size(), 0);
  for (std::size_t i = 0; i < curve.size(); i += 2) {
    curve.sharp[i] = 1;
    const double x = coordinate(random);
    const double y = coordinate(random);
    curve.centre[i] = {x, y, coordinate(random)};
  }
  return surface;
}

DooSabinSurface InterpolatingSurface(const PolygonMesh& given) {
  InterpolateResult result =
      OrThrow(Interpolate(Context(), given, {.surface = false, .keep_patches = true}));
  return std::get<DooSabinSurface>(*std::move(result.patches));
}

DooSabinSurface RefinedSurface(const DooSabinSurface& surface) {
  const HalfEdgeMesh& mesh = surface.mesh;
  PolygonMesh split;
  split.positions.resize(mesh.vertex_count() + mesh.edge_count() + mesh.face_count());
  split.corner_vertex.resize(4 * mesh.half_edge_count());
  OrThrow(QuadVertices(Context(), mesh, absl::MakeSpan(split.corner_vertex)));
  split.face_begin.resize(mesh.half_edge_count() + 1);
  for (std::size_t f = 0; f <= mesh.half_edge_count(); ++f) {
    split.face_begin[f] = static_cast<Index>(4 * f);
  }
  DooSabinSurface refined = SurfaceOf(split);
  const ExtraordinaryFans fans = OrThrow(FindExtraordinaryFans(Context(), mesh));
  OrThrow(RefineDooSabin(Context(),
                         {.mesh = mesh, .fans = fans, .k = 1, .boundary = &surface.boundary},
                         surface.corners, absl::MakeSpan(refined.corners)));
  // In the order of T^1's own boundary.
  const BoundaryCurve curve = OrThrow(RefineBoundary(Context(), mesh, surface.boundary));
  refined.boundary.sharp.resize(curve.sharp.size());
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Index at = refined.boundary.Find(curve.half_edge[i]);
    if (!curve.sharp.empty()) refined.boundary.sharp[at] = curve.sharp[i];
    refined.boundary.centre[at] = curve.centre[i];
    refined.boundary.start[at] = curve.start[i];
    refined.boundary.end[at] = curve.end[i];
  }
  return refined;
}

SurfaceParameter RefinedParameter(const DooSabinSurface& surface, const SurfaceParameter& p) {
  const Index h = surface.mesh.face_begin()[p.face] + p.corner;
  // u and v of each quarter turn with it.
  if (p.u <= 0.5 && p.v <= 0.5) return {h, 0, 2 * p.u, 2 * p.v};
  if (p.v <= 0.5) return {h, 1, 2 * p.v, 2 * (1 - p.u)};
  if (p.u <= 0.5) return {h, 3, 2 * (1 - p.v), 2 * p.u};
  return {h, 2, 2 * (1 - p.u), 2 * (1 - p.v)};
}

SurfaceParameter AtHalfEdge(const HalfEdgeMesh& mesh, Index h, double u, double v) {
  const Index face = mesh.face()[h];
  return {face, h - mesh.face_begin()[face], u, v};
}

DeepSurface Refined(const DooSabinSurface& surface, std::uint32_t level) {
  const Context context;
  const ExtraordinaryFans fans = OrThrow(FindExtraordinaryFans(context, surface.mesh));
  Buffer<Vec3> corners = surface.corners;
  BoundaryCurve boundary = surface.boundary;
  // T^(level - 1): the input's first, then one that takes its place.
  const HalfEdgeMesh* mesh = &surface.mesh;
  HalfEdgeMesh split = OrThrow(SplitIntoQuads(context, surface.mesh));
  for (std::uint32_t k = 1; k < level; ++k) {
    Buffer<Vec3> refined(4 * corners.size());
    OrThrow(RefineDooSabin(context, {.mesh = *mesh, .fans = fans, .k = k, .boundary = &boundary},
                           corners, absl::MakeSpan(refined)));
    corners = std::move(refined);
    boundary = OrThrow(RefineBoundary(context, *mesh, boundary));
    if (k > 1) split = OrThrow(SplitIntoQuads(context, split));
    mesh = &split;
  }
  DeepSurface deep;
  deep.cells = std::size_t{1} << (level - 1);
  deep.points.resize(mesh->vertex_count() + mesh->edge_count() + mesh->face_count());
  deep.normals.resize(deep.points.size());
  OrThrow(DooSabinLimit(
      context, {.mesh = *mesh, .fans = fans, .k = level, .boundary = &boundary}, corners,
      {.points = absl::MakeSpan(deep.points), .normals = absl::MakeSpan(deep.normals)}));
  std::vector<Index> quads(4 * mesh->half_edge_count());
  OrThrow(QuadVertices(context, *mesh, absl::MakeSpan(quads)));
  const auto places = QuadPlaces(surface.mesh.half_edge_count(), level);
  const std::size_t row = deep.cells + 1;
  deep.vertex.resize(surface.mesh.half_edge_count() * row * row);
  for (std::size_t q = 0; q < places.size(); ++q) {
    const std::size_t h = q / (deep.cells * deep.cells);
    for (std::size_t j = 0; j < 4; ++j) {
      deep.vertex[(h * row + places[q][j].second) * row + places[q][j].first] = quads[4 * q + j];
    }
  }
  return deep;
}

GridParameters AllOf(const DooSabinSurface& surface, const DeepSurface& deep) {
  GridParameters all;
  for (Index h = 0; h < surface.mesh.half_edge_count(); ++h) {
    for (std::size_t j = 0; j <= deep.cells; ++j) {
      for (std::size_t i = 0; i <= deep.cells; ++i) {
        all.parameters.push_back(AtHalfEdge(surface.mesh, h, deep.At(i), deep.At(j)));
        all.vertices.push_back(deep.VertexAt(h, i, j));
      }
    }
  }
  return all;
}

std::vector<SurfaceParameter> SomeParameters(const HalfEdgeMesh& mesh, std::size_t n,
                                             std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto coordinate = [&] {
    const double t = std::uniform_real_distribution<double>(0, 1)(random);
    switch (random() % 8) {
      case 0:
        return 0.0;
      case 1:
        return 1.0;
      case 2:
        return std::ldexp(t, -static_cast<int>(random() % 1100));
      case 3:
        return 1 - std::ldexp(t, -static_cast<int>(random() % 60));
      default:
        return t;
    }
  };
  std::vector<SurfaceParameter> parameters;
  for (std::size_t i = 0; i < n; ++i) {
    const auto h = static_cast<Index>(random() % mesh.half_edge_count());
    const double u = coordinate();
    parameters.push_back(AtHalfEdge(mesh, h, u, coordinate()));
  }
  return parameters;
}

std::uint32_t DeepLevel(const HalfEdgeMesh& mesh, std::size_t most) {
  std::uint32_t level = 1;
  while (level < 8 && (mesh.half_edge_count() << (2 * level)) <= most) ++level;
  return level;
}

SurfaceSamples Samples::Spans() {
  return {.points = absl::MakeSpan(points),
          .du = absl::MakeSpan(du),
          .dv = absl::MakeSpan(dv),
          .normals = absl::MakeSpan(normals)};
}

Samples Evaluated(const DooSabinSurface& surface, const std::vector<SurfaceParameter>& parameters) {
  Samples samples(parameters.size());
  OrThrow(EvaluateSurface(Context(), surface, parameters, samples.Spans()));
  return samples;
}

}  // namespace limn::oracle
