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
#include "engine/refine/doo_sabin_refine.h"
#include "engine/refine/quad_split.h"
#include "tests/oracle/deep_surface.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/features.h"
#include "tests/oracle/open_meshes.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

FeatureValues Planes(const std::vector<Index>& faces, double edge = 0.4) {
  FeatureValues values = {.default_edge = edge};
  for (const Index f : faces) values.faces.push_back({f, FaceKind::kPlane});
  return values;
}

InterpolateResult Made(const PolygonMesh& mesh, const FeatureValues& values, std::uint32_t level) {
  InterpolateOptions options = {.level = level, .keep_patches = true};
  options.constraints.features = values;
  auto result = Interpolate(Context{}, mesh, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

absl::Status Refusal(const PolygonMesh& mesh, const FeatureValues& values) {
  InterpolateOptions options = {.level = 1};
  options.constraints.features = values;
  return Interpolate(Context{}, mesh, options).status();
}

// The vertices of T^level in each face of T^0: the quads of a corner of T^(k - 1) are its four.
std::vector<std::set<Index>> VerticesByFace(const PolygonMesh& mesh, const Tessellation& surface) {
  std::size_t per_corner = 1;
  for (std::uint32_t k = 1; k < surface.level; ++k) per_corner *= 4;
  std::vector<std::set<Index>> vertices(mesh.face_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t q = mesh.face_begin[f] * per_corner; q < mesh.face_begin[f + 1] * per_corner;
         ++q) {
      for (std::size_t i = 0; i < 4; ++i) vertices[f].insert(surface.face_vertices[4 * q + i]);
    }
  }
  return vertices;
}

struct PlaneCase {
  std::string name;
  PolygonMesh mesh;
  std::vector<Index> planes;
};
void PrintTo(const PlaneCase& c, std::ostream* out) { *out << c.name; }

// A cone of `sides` triangles over a polygon, face 0: around the tip there are as many faces.
PolygonMesh Cone(int sides) {
  PolygonMesh prism = oracle::Prism(sides);
  PolygonMesh cone;
  for (int i = 0; i < sides; ++i) cone.positions.push_back(prism.positions[prism.face(0)[i]]);
  cone.positions.push_back({0.1, 0.2, 3});
  Buffer<Index> base;
  for (int i = 0; i < sides; ++i) base.push_back(static_cast<Index>(i));
  // Away from the tip.
  double turn = 0;
  for (int i = 0; i < sides; ++i) {
    turn += Cross(cone.positions[i], cone.positions[(i + 1) % sides]).z;
  }
  if (turn > 0) std::reverse(base.begin(), base.end());
  cone.AddFace(base);
  for (int i = 0; i < sides; ++i) {
    cone.AddFace({base[(i + 1) % sides], base[i], static_cast<Index>(sides)});
  }
  return cone;
}

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
    ASSERT_TRUE(
        EvaluateSurface(Context{}, *result.patches, parameters, {.points = absl::MakeSpan(points)})
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
    const oracle::DeepSurface places = oracle::Refined(*usual.patches, level);
    const oracle::GridParameters grid = oracle::AllOf(*usual.patches, places);
    const oracle::Samples samples = oracle::Evaluated(*result.patches, grid.parameters);
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
  const oracle::DeepSurface places = oracle::Refined(*usual.patches, 2);
  const oracle::GridParameters grid = oracle::AllOf(*usual.patches, places);
  const oracle::Samples samples = oracle::Evaluated(*result.patches, grid.parameters);
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
  const oracle::DeepSurface places = oracle::Refined(*usual.patches, level);
  // At the middle of each quad the surface is not far from the nearest point of its triangles.
  const double cells = static_cast<double>(places.cells);
  std::vector<SurfaceParameter> parameters;
  std::vector<std::array<Vec3, 4>> quads;
  for (Index h = 0; h < mesh_.corner_count(); h += 3) {
    for (std::size_t j = 0; j < places.cells; ++j) {
      for (std::size_t i = 0; i < places.cells; ++i) {
        parameters.push_back(oracle::AtHalfEdge(usual.patches->mesh, h,
                                                (static_cast<double>(i) + 0.5) / cells,
                                                (static_cast<double>(j) + 0.5) / cells));
        const auto at = [&](std::size_t a, std::size_t b) {
          return result.surface.positions[places.VertexAt(h, a, b)];
        };
        quads.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }
  const oracle::Samples samples = oracle::Evaluated(*result.patches, parameters);
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

TEST(PlaneFaces, AMeshOfPlaneFacesOnlyIsThePolyhedron) {
  for (const PolygonMesh& mesh : {oracle::Cube(), oracle::Octahedron(), oracle::Dodecahedron(),
                                  oracle::GenusThree(), oracle::Prism(9)}) {
    FeatureValues values = {.default_face = FaceKind::kPlane};
    for (const std::uint32_t level : {0U, 1U, 3U}) {
      const InterpolateResult result = Made(mesh, values, level);
      for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
        ASSERT_EQ(result.surface.positions[v], mesh.positions[v]);
      }
    }
    // Of the same volume and area, and nothing folded.
    const InterpolateResult result = Made(mesh, values, 3);
    const auto area = [](const Buffer<Vec3>& points, absl::Span<const Index> face) {
      Vec3 sum = {0, 0, 0};
      for (std::size_t i = 1; i + 1 < face.size(); ++i) {
        sum += Cross(points[face[i]] - points[face[0]], points[face[i + 1]] - points[face[0]]);
      }
      return 0.5 * Norm(sum);
    };
    double given = 0;
    for (std::size_t f = 0; f < mesh.face_count(); ++f) given += area(mesh.positions, mesh.face(f));
    double found = 0;
    for (std::size_t q = 0; q < result.surface.face_count(); ++q) {
      found += area(result.surface.positions,
                    absl::MakeConstSpan(result.surface.face_vertices).subspan(4 * q, 4));
    }
    EXPECT_NEAR(found, given, 1e-12 * given);
  }
}

// p_4 = 4 C - p_1 - p_2 - p_3, and the mirrored images of section 3.2.2.
TEST(PlaneFaces, CornersAreThePapers) {
  const PolygonMesh cube = oracle::Cube();
  const FeatureValues values = Planes({0, 2}, 0.3);
  const InterpolateResult result = Made(cube, values, 1);
  const DooSabinSurface& surface = *result.patches;
  const HalfEdgeMesh built = oracle::BuildOrDie(cube);
  const PolygonWalk walk(built);
  const oracle::Points images = oracle::AllFeatureImages(oracle::FromPolygonMesh(cube), values);
  std::size_t corners = 0;
  BoundaryFace face;
  for (Index i = 0; i < surface.boundary.size(); ++i) {
    const Index h = surface.boundary.half_edge[i];
    const Index f = built.face()[h];
    GatherBoundaryFace(surface.mesh, surface.boundary, surface.corners.data(), i, &face);
    if (f == 0 || f == 2 || !surface.boundary.IsSharp(i)) continue;
    ++corners;
    ASSERT_EQ(face.point.size(), 4U);
    const Vec3 c = cube.positions[built.vertex()[h]];
    EXPECT_LE(MaxAbs(face.point[2] - (4 * c - face.point[0] - face.point[1] - face.point[3])),
              1e-15);
    const oracle::Point image = images[h];
    const Vec3 p = {static_cast<double>(image.x), static_cast<double>(image.y),
                    static_cast<double>(image.z)};
    EXPECT_LE(MaxAbs(face.point[0] - p), 1e-15);
    // Mirrored in the feet on both edges.
    for (const auto& [other, ghost] : {std::pair{walk.Next(h), 3}, {walk.Prev(h), 1}}) {
      const Vec3 e = NormalizedOrZero(cube.positions[built.vertex()[other]] - c);
      const Vec3 foot = c + Dot(p - c, e) * e;
      EXPECT_LE(MaxAbs(face.point[static_cast<std::size_t>(ghost)] - (2 * foot - p)), 1e-15);
    }
  }
  EXPECT_EQ(corners, 2U);
}

// Sharp vertices of m faces: refining the whole face by [ZC Eq. 1] gives the face that is gathered
// after refinement. So ghosts are vertices of a Doo-Sabin mesh like any other.
TEST(PlaneFaces, GhostsOfSharpVerticesRefineIntoGhosts) {
  for (const int sides : {6, 8, 13}) {
    const InterpolateResult result = Made(Cone(sides), Planes({1, 4}, 0.35), 0);
    const DooSabinSurface& surface = *result.patches;
    const Context context;
    LIMN_ASSERT_OK_AND_ASSIGN(const ExtraordinaryFans fans,
                              FindExtraordinaryFans(context, surface.mesh));
    Buffer<Vec3> refined(4 * surface.corners.size());
    ASSERT_TRUE(
        RefineDooSabin(context,
                       {.mesh = surface.mesh, .fans = fans, .k = 1, .boundary = &surface.boundary},
                       surface.corners, absl::MakeSpan(refined))
            .ok());
    LIMN_ASSERT_OK_AND_ASSIGN(const BoundaryCurve curve,
                              RefineBoundary(context, surface.mesh, surface.boundary));
    LIMN_ASSERT_OK_AND_ASSIGN(const HalfEdgeMesh split, SplitIntoQuads(context, surface.mesh));
    std::size_t wide = 0;
    BoundaryFace face;
    for (Index i = 0; i < surface.boundary.size(); ++i) {
      GatherBoundaryFace(surface.mesh, surface.boundary, surface.corners.data(), i, &face);
      const std::size_t m = face.corner.size();
      ASSERT_EQ(face.point.size(), surface.boundary.SidesAt(i, m));
      if (surface.boundary.IsSharp(i) && m > 1) ++wide;
      oracle::Points expected = oracle::FromVec3(face.point);
      EXPECT_LE(oracle::Norm(oracle::Centroid(expected) -
                             oracle::FromVec3({surface.boundary.centre[i]})[0]),
                1e-14L);
      expected = oracle::Equation1(expected);
      // Half-edge i is the first of the two that it is split into.
      GatherBoundaryFace(split, curve, refined.data(), 2 * i, &face);
      ASSERT_EQ(face.point.size(), expected.size());
      EXPECT_LE(oracle::MaxDistance(oracle::FromVec3(face.point), expected), 1e-14L) << m;
    }
    EXPECT_GE(wide, 2U);
  }
}

PolygonMesh LiftedCube(double lift) {
  PolygonMesh cube = oracle::Cube();
  cube.positions[cube.face(0)[0]].x += lift;
  cube.positions[cube.face(0)[0]].y += lift;
  cube.positions[cube.face(0)[0]].z += lift;
  return cube;
}

TEST(PlaneFaces, FacesThatAreNotPlanarAreMadePlanar) {
  const PolygonMesh cube = LiftedCube(0.1);
  for (const std::vector<Index>& planes :
       {std::vector<Index>{0}, {0, 2}, {0, 2, 4}, {0, 1, 2, 3, 4, 5}}) {
    const InterpolateResult result = Made(cube, Planes(planes), 3);
    const auto vertices = VerticesByFace(cube, result.surface);
    for (const Index f : planes) {
      std::vector<Vec3> points;
      for (const Index v : vertices[f]) points.push_back(result.surface.positions[v]);
      // The plane through the mean along the average normal, by the oracle.
      oracle::Points corners;
      for (const Index v : cube.face(f)) corners.push_back(oracle::FromVec3(cube.positions)[v]);
      const oracle::Point middle = oracle::Centroid(corners);
      for (oracle::Point& p : corners) p = p - middle;
      const oracle::Point normal = oracle::Equation10(corners);
      for (const oracle::Point& p : oracle::FromVec3(points)) {
        ASSERT_LE(std::fabs(oracle::Dot(normal, p - middle)), 1e-12L);
      }
    }
  }
}

TEST(PlaneFaces, PlanarOnesStayAsTheyAreToTheBit) {
  const PolygonMesh cube = oracle::Cube();
  const HalfEdgeMesh mesh = oracle::BuildOrDie(cube);
  LIMN_ASSERT_OK_AND_ASSIGN(const FeatureTable table,
                            MakeFeatureTable(Context{}, mesh, Planes({0, 1, 2, 3, 4, 5})));
  LIMN_ASSERT_OK_AND_ASSIGN(
      const Buffer<Vec3> moved,
      FlattenPlaneFaces(Context{}, mesh, table, {.points = cube.positions, .scale = 3.5}));
  EXPECT_TRUE(moved.empty());
}

TEST(PlaneFaces, MovedVerticesGoTheShortestWay) {
  const PolygonMesh cube = LiftedCube(0.1);
  const HalfEdgeMesh mesh = oracle::BuildOrDie(cube);
  LIMN_ASSERT_OK_AND_ASSIGN(const FeatureTable table,
                            MakeFeatureTable(Context{}, mesh, Planes({0})));
  LIMN_ASSERT_OK_AND_ASSIGN(
      const Buffer<Vec3> moved,
      FlattenPlaneFaces(Context{}, mesh, table, {.points = cube.positions, .scale = 3.5}));
  ASSERT_EQ(moved.size(), 8U);
  const absl::Span<const Index> face = cube.face(0);
  Vec3 first = {0, 0, 0};
  for (std::size_t v = 0; v < 8; ++v) {
    const Vec3 by = moved[v] - cube.positions[v];
    if (std::count(face.begin(), face.end(), static_cast<Index>(v)) == 0) {
      EXPECT_EQ(by, (Vec3{0, 0, 0}));
      continue;
    }
    // All along the normal.
    if (first == Vec3{0, 0, 0}) first = NormalizedOrZero(by);
    EXPECT_LE(Norm(Cross(first, by)), 1e-14);
  }
}

TEST(PlaneFaces, WhatHasNoPlaneIsRefused) {
  // A face on a line.
  PolygonMesh line = oracle::Cube();
  const absl::Span<const Index> face = line.face(3);
  for (std::size_t i = 0; i < 4; ++i) {
    line.positions[face[i]] = {static_cast<double>(i), 2 * static_cast<double>(i), 0};
  }
  oracle::ExpectError(Refusal(line, Planes({3})),
                      {Reason::kInvalidOption, "constraints.features", 3});
  // Four planes in general position around the tip.
  PolygonMesh cone = Cone(6);
  std::vector<Index> all;
  for (Index f = 0; f < 7; ++f) all.push_back(f);
  EXPECT_TRUE(Refusal(cone, Planes(all)).ok());
  PolygonMesh bent = oracle::GenusThree();
  bent = oracle::Jittered(bent, 8, 0.2);
  const absl::Status status = Refusal(bent, {.default_face = FaceKind::kPlane});
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("far from planar"), std::string_view::npos) << status;
}

TEST(PlaneFaces, InterpolatedVerticesAreCorners) {
  const PolygonMesh cube = oracle::Cube();
  InterpolateOptions options = {.level = 2};
  options.constraints.features = Planes({0});
  const Index on_plane = cube.face(0)[1];
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult without, Interpolate(Context{}, cube, options));
  EXPECT_GT(Norm(without.surface.positions[on_plane] - cube.positions[on_plane]), 0.1);
  options.constraints.interpolate = {on_plane};
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult with, Interpolate(Context{}, cube, options));
  EXPECT_EQ(with.surface.positions[on_plane], cube.positions[on_plane]);
  const Vec3& at = cube.positions[on_plane];
  const Vec3 normal =
      Cross(cube.positions[cube.face(0)[0]] - at, cube.positions[cube.face(0)[2]] - at);
  const auto vertices = VerticesByFace(cube, with.surface);
  for (const Index v : vertices[0]) {
    EXPECT_LE(std::fabs(Dot(normal, with.surface.positions[v] - at)), 1e-15);
  }
}

TEST(PlaneFaces, NormalsHandlesAndMovedPointsAreRefusedThere) {
  const PolygonMesh cube = LiftedCube(0.1);
  const Index v = cube.face(0)[0];
  InterpolateOptions options = {.level = 1};
  options.constraints.features = Planes({0});
  options.constraints.interpolate = {v};
  oracle::ExpectError(Interpolate(Context{}, cube, options).status(),
                      {Reason::kInvalidOption, "constraints.interpolate.vertices[0]", 0});
  options.constraints.normals = {{v, {0, 0, 1}}};
  oracle::ExpectError(Interpolate(Context{}, oracle::Cube(), options).status(),
                      {Reason::kInvalidOption, "constraints.normals[0]", 0});
  options.constraints.normals.clear();
  options.constraints.shape_handles = {{v, 2}};
  oracle::ExpectError(Interpolate(Context{}, oracle::Cube(), options).status(),
                      {Reason::kInvalidOption, "constraints.shape_handles[0]", 0});
}

// Feet beyond the ends of an edge, and in the wrong order.
TEST(PlaneFaces, FeetStayOnTheirEdgeAndInOrder) {
  PolygonMesh prism = oracle::Prism(4);
  // The lower face becomes wide: sides lean outwards, so feet of deep images fall inside still; of
  // a side that leans over one end they do not.
  const absl::Span<const Index> top = prism.face(0);
  for (const Index v : top) prism.positions[v].x += 9;
  const FeatureValues values = Planes({0}, 0.9);
  const InterpolateResult result = Made(prism, values, 0);
  const BoundaryCurve& curve = result.patches->boundary;
  const HalfEdgeMesh built = oracle::BuildOrDie(prism);
  std::size_t at_an_end = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Index h = curve.half_edge[i];
    const Vec3& a = prism.positions[built.vertex()[h]];
    const Vec3& b = prism.positions[built.vertex()[PolygonWalk(built).Next(h)]];
    const double along = Dot(b - a, b - a);
    const double s = Dot(curve.start[i] - a, b - a) / along;
    const double t = Dot(curve.end[i] - a, b - a) / along;
    EXPECT_GE(s, -1e-15);
    EXPECT_LE(s, t + 1e-15);
    EXPECT_LE(t, 1 + 1e-15);
    if (t - s < 1e-12) ++at_an_end;
  }
  EXPECT_GT(at_an_end, 0U);
}

}  // namespace
}  // namespace limn
