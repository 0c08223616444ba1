// SPDX-License-Identifier: MIT
// Plane faces: planar regions with the boundary that section 3.2.2 of Xu and Kondo describes,
// corners, meshes of plane faces only, faces that are not planar, and the tessellation in one
// piece.
#include "engine/constraints/feature_planes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/constraints/features.h"
#include "engine/interpolate.h"
#include "engine/limit/evaluate.h"
#include "tests/engine/feature_planes_testing.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/features.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

struct PlaneCase {
  std::string name;
  PolygonMesh mesh;
  std::vector<Index> planes;
};
void PrintTo(const PlaneCase& c, std::ostream* out) { *out << c.name; }

std::vector<PlaneCase> Cases() {
  return {
      {"cube_one", oracle::Cube(), {0}},
      {"cube_opposite", oracle::Cube(), {0, 1}},
      {"cube_two", oracle::Cube(), {0, 2}},
      {"cube_three", oracle::Cube(), {0, 2, 4}},
      {"cube_five", oracle::Cube(), {0, 1, 2, 3, 4}},
      {"cube_all", oracle::Cube(), {0, 1, 2, 3, 4, 5}},
      {"prism_top", oracle::Prism(7), {0}},
      {"prism_side", oracle::Prism(5), {3}},
      {"octahedron_one", oracle::Octahedron(), {0}},
      {"octahedron_apart", oracle::Octahedron(), {0, 2}},
      {"octahedron_all", oracle::Octahedron(), {0, 1, 2, 3, 4, 5, 6, 7}},
      {"pyramid_tip", Cone(9), {1, 5}},
      {"pyramid_tip_next", Cone(12), {1, 2, 7}},
      {"pyramid_base", Cone(6), {0}},
      {"hub", oracle::DoublePyramid(40), {0}},
      {"hub_apart", oracle::DoublePyramid(40), {0, 19}},
      {"dodecahedron", oracle::Dodecahedron(), {0, 3, 7}},
      {"two_components", oracle::TwoComponents(), {0, 5}},
      {"genus_three", oracle::GenusThree(), {3, 4, 11}},
      {"pillow", oracle::Pillow(5), {0}},
      {"open_grid", oracle::QuadPatch(4, 3), {0, 5}},
  };
}

class PlaneFaceTest : public testing::TestWithParam<PlaneCase> {
 protected:
  PlaneFaceTest() : mesh_(GetParam().mesh), planes_(GetParam().planes) {
    if (GetParam().name != "open_grid" && GetParam().name != "pillow") return;
    // Flat, so that their faces have planes.
    for (Vec3& p : mesh_.positions) p.z = 0.1 * p.x;
  }

  bool IsPlane(Index f) const { return std::count(planes_.begin(), planes_.end(), f) > 0; }

  PolygonMesh mesh_;
  std::vector<Index> planes_;
};

TEST_P(PlaneFaceTest, RegionsArePlanar) {
  for (const std::uint32_t level : {1U, 2U, 4U}) {
    const InterpolateResult result = Made(mesh_, Planes(planes_), level);
    const auto vertices = VerticesByFace(mesh_, result.surface);
    for (const Index f : planes_) {
      const Vec3& a = mesh_.positions[mesh_.face(f)[0]];
      const Vec3 normal = NormalizedOrZero(
          Cross(mesh_.positions[mesh_.face(f)[1]] - a, mesh_.positions[mesh_.face(f)[2]] - a));
      for (const Index v : vertices[f]) {
        ASSERT_LE(std::fabs(Dot(normal, result.surface.positions[v] - a)), 1e-12) << f;
      }
    }
  }
}

// The control polygon of a region's boundary: around the face, the curve's points of each edge.
struct ControlPolygon {
  std::vector<Vec3> point;
  // Whether the curve ends at `corner` after this point, instead of half way to the next.
  std::vector<bool> ends;
  std::vector<Vec3> corner;
};

// From the words of section 3.2.2: feet, ends of edges, corners.
ControlPolygon PolygonOf(const PolygonMesh& mesh, const std::vector<Index>& planes, Index f,
                         const FeatureValues& values) {
  const HalfEdgeMesh built = oracle::BuildOrDie(mesh);
  const PolygonWalk walk(built);
  const oracle::Mesh given = oracle::FromPolygonMesh(mesh);
  const oracle::Points images = oracle::AllFeatureImages(given, values);
  const auto is_plane = [&](Index h) {
    return std::count(planes.begin(), planes.end(), built.face()[h]) > 0;
  };
  ControlPolygon polygon;
  for (Index h = walk.FaceBegin(f); h < walk.FaceEnd(f); ++h) {
    const Index v = built.vertex()[h];
    const Index next = built.vertex()[walk.Next(h)];
    const Index twin = built.twin()[h];
    const oracle::Point a = given.points[v];
    const oracle::Point b = given.points[next];
    // A line from end to end has its ends as control points; halves of it do as well.
    std::pair<oracle::Point, oracle::Point> feet = {0.5L * (a + b), 0.5L * (a + b)};
    if (twin != kNoIndex && !is_plane(twin)) {
      feet = oracle::FeetOf(a, b, images[walk.Next(twin)], images[twin]);
    }
    std::size_t around = 0;
    for (Index i = built.fan_begin()[next]; i < built.fan_begin()[next + 1]; ++i) {
      if (is_plane(built.fan()[i])) ++around;
    }
    const bool corner = around > 1 || built.IsBoundary(next);
    for (const oracle::Point& p : {feet.first, feet.second}) {
      polygon.point.push_back(
          {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)});
    }
    polygon.ends.push_back(false);
    polygon.ends.push_back(corner);
    polygon.corner.push_back({0, 0, 0});
    polygon.corner.push_back(mesh.positions[next]);
  }
  return polygon;
}

// Points of the quadratic B-spline from the middle (or corner) before control point i to that after
// it.
Vec3 SplinePoint(const ControlPolygon& polygon, std::size_t i, double t) {
  const std::size_t n = polygon.point.size();
  const std::size_t before = (i + n - 1) % n;
  const std::size_t next = (i + 1) % n;
  const Vec3 from = polygon.ends[before] ? polygon.corner[before]
                                         : 0.5 * (polygon.point[before] + polygon.point[i]);
  const Vec3 to =
      polygon.ends[i] ? polygon.corner[i] : 0.5 * (polygon.point[i] + polygon.point[next]);
  return (1 - t) * (1 - t) * from + 2 * t * (1 - t) * polygon.point[i] + t * t * to;
}

TEST_P(PlaneFaceTest, RegionsAreBoundedByTheBSplineOfTheFeet) {
  const FeatureValues values = Planes(planes_, 0.3);
  const InterpolateResult result = Made(mesh_, values, 0);
  for (const Index f : planes_) {
    const ControlPolygon polygon = PolygonOf(mesh_, planes_, f, values);
    const std::size_t m = mesh_.arity(f);
    std::vector<SurfaceParameter> parameters;
    std::vector<Vec3> expected;
    for (Index c = 0; c < m; ++c) {
      const Index h = mesh_.face_begin[f] + c;
      const HalfEdgeMesh built = oracle::BuildOrDie(mesh_);
      const Index twin = built.twin()[h];
      const bool line = twin == kNoIndex || IsPlane(built.face()[twin]);
      for (const double t : {0.0, 0.25, 0.5, 0.8, 1.0}) {
        // From the vertex to the edge's middle.
        parameters.push_back({f, c, t, 0});
        // Straight edges have other control points and the same line; only their parameter differs.
        if (line) {
          const Vec3& a = mesh_.positions[built.vertex()[h]];
          const Vec3& b = mesh_.positions[built.vertex()[PolygonWalk(built).Next(h)]];
          expected.push_back(a + 0.5 * t * (b - a));
          continue;
        }
        expected.push_back(SplinePoint(polygon, 2 * c, t));
      }
    }
    std::vector<Vec3> points(parameters.size());
    ASSERT_TRUE(EvaluateSurface(Context{}, std::get<DooSabinSurface>(*result.patches), parameters,
                                {.points = absl::MakeSpan(points)})
                    .ok());
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_LE(MaxAbs(points[i] - expected[i]), 1e-13)
          << f << " " << parameters[i].corner << " " << parameters[i].u;
    }
  }
}

// The numbering contract holds, and each vertex is the surface's point there in every face around.
TEST_P(PlaneFaceTest, TheTessellationIsTheSurfaceInOnePiece) {
  const FeatureValues values = Planes(planes_, 0.6);
  for (const std::uint32_t level : {0U, 1U, 2U, 3U}) {
    const InterpolateResult result = Made(mesh_, values, level);
    LIMN_ASSERT_OK_AND_ASSIGN(
        const InterpolateResult usual,
        Interpolate(Context{}, mesh_, {.level = level, .keep_patches = true}));
    ASSERT_EQ(result.surface.vertex_count(), usual.surface.vertex_count());
    ASSERT_EQ(result.surface.normals.size(), usual.surface.normals.size());
    ASSERT_EQ(result.surface.face_vertices, usual.surface.face_vertices);
    ASSERT_EQ(result.surface.face_begin, usual.surface.face_begin);
    if (level == 0) continue;
    // The usual surface says which vertices are where.
    const oracle::DeepSurface places =
        oracle::Refined(std::get<DooSabinSurface>(*usual.patches), level);
    const oracle::GridParameters grid =
        oracle::AllOf(std::get<DooSabinSurface>(*usual.patches), places);
    const oracle::Samples samples =
        oracle::Evaluated(std::get<DooSabinSurface>(*result.patches), grid.parameters);
    for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
      ASSERT_LE(MaxAbs(result.surface.positions[grid.vertices[i]] - samples.points[i]), 1e-14)
          << "level " << level << ", face " << grid.parameters[i].face;
    }
  }
}

// Inside a region and inside the surface they are those of the surface, at its edges in between.
TEST_P(PlaneFaceTest, NormalsAreThoseOfTheSidesOrTheirMean) {
  const InterpolateResult result = Made(mesh_, Planes(planes_), 2);
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult usual,
                            Interpolate(Context{}, mesh_, {.level = 2, .keep_patches = true}));
  const oracle::DeepSurface places = oracle::Refined(std::get<DooSabinSurface>(*usual.patches), 2);
  const oracle::GridParameters grid =
      oracle::AllOf(std::get<DooSabinSurface>(*usual.patches), places);
  const oracle::Samples samples =
      oracle::Evaluated(std::get<DooSabinSurface>(*result.patches), grid.parameters);
  std::vector<std::vector<Vec3>> seen(result.surface.vertex_count());
  for (std::size_t i = 0; i < grid.vertices.size(); ++i) {
    const Index f = grid.parameters[i].face;
    Vec3 normal = samples.normals[i];
    if (IsPlane(f)) {
      const Vec3& a = mesh_.positions[mesh_.face(f)[0]];
      normal = NormalizedOrZero(
          Cross(mesh_.positions[mesh_.face(f)[1]] - a, mesh_.positions[mesh_.face(f)[2]] - a));
      // Where the parameters span no plane the region has it nevertheless.
      if (samples.normals[i] != Vec3{0, 0, 0}) {
        ASSERT_LE(MaxAbs(samples.normals[i] - normal), 1e-6);
      }
    }
    std::vector<Vec3>& normals = seen[grid.vertices[i]];
    const auto same = [&](const Vec3& n) { return MaxAbs(n - normal) < 1e-6; };
    if (std::none_of(normals.begin(), normals.end(), same)) normals.push_back(normal);
  }
  for (std::size_t v = 0; v < seen.size(); ++v) {
    // Coplanar parts count as one here and as several there: their mean may differ.
    if (seen[v].size() > 2) continue;
    Vec3 sum = {0, 0, 0};
    for (const Vec3& n : seen[v]) sum += n;
    const Vec3 mean = Norm(sum) > 1e-9 ? NormalizedOrZero(sum) : Vec3{0, 0, 0};
    ASSERT_LE(MaxAbs(result.surface.normals[v] - mean), 1e-6) << v;
  }
}

TEST_P(PlaneFaceTest, ChordBoundsHold) {
  InterpolateOptions options = {.chord_tolerance = 0.03, .finest = 7, .keep_patches = true};
  options.constraints.features = Planes(planes_, 0.7);
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Interpolate(Context{}, mesh_, options));
  const std::uint32_t level = result.surface.level;
  if (level == 0) return;
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult usual,
                            Interpolate(Context{}, mesh_, {.level = level, .keep_patches = true}));
  const oracle::DeepSurface places =
      oracle::Refined(std::get<DooSabinSurface>(*usual.patches), level);
  // At the middle of each quad the surface is not far from the nearest point of its triangles.
  const double cells = static_cast<double>(places.cells);
  std::vector<SurfaceParameter> parameters;
  std::vector<std::array<Vec3, 4>> quads;
  for (Index h = 0; h < mesh_.corner_count(); h += 3) {
    for (std::size_t j = 0; j < places.cells; ++j) {
      for (std::size_t i = 0; i < places.cells; ++i) {
        parameters.push_back(oracle::AtHalfEdge(std::get<DooSabinSurface>(*usual.patches).mesh, h,
                                                (static_cast<double>(i) + 0.5) / cells,
                                                (static_cast<double>(j) + 0.5) / cells));
        const auto at = [&](std::size_t a, std::size_t b) {
          return result.surface.positions[places.VertexAt(h, a, b)];
        };
        quads.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }
  const oracle::Samples samples =
      oracle::Evaluated(std::get<DooSabinSurface>(*result.patches), parameters);
  for (std::size_t q = 0; q < quads.size(); ++q) {
    // The point of the bilinear patch is within the bound of both splits at the parameter's, so
    // twice the bound is generous for the nearest of nine points around, and wrong bounds fail it.
    double nearest = 1e9;
    for (int a = 0; a <= 32; ++a) {
      for (int b = 0; b <= 32; ++b) {
        const double s = a / 32.0;
        const double t = b / 32.0;
        const Vec3 p = (1 - s) * ((1 - t) * quads[q][0] + t * quads[q][3]) +
                       s * ((1 - t) * quads[q][1] + t * quads[q][2]);
        nearest = std::min(nearest, Norm(samples.points[q] - p));
      }
    }
    double size = 0;
    for (const Vec3& p : quads[q]) size = std::max(size, Norm(p - quads[q][0]));
    ASSERT_LE(nearest, 1.5 * *result.chord_bound + size / 32) << q;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PlaneFaceTest, testing::ValuesIn(Cases()),
                         [](const auto& c) { return c.param.name; });

}  // namespace
}  // namespace limn
