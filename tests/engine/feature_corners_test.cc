// SPDX-License-Identifier: MIT
// Plane faces one by one: polyhedra, corners and their ghosts, faces that are not planar, feet, and
// what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/constraints/feature_planes.h"
#include "engine/constraints/features.h"
#include "engine/interpolate.h"
#include "engine/mesh/quad_split.h"
#include "engine/refine/doo_sabin_refine.h"
#include "tests/engine/feature_planes_testing.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/features.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

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
  const DooSabinSurface& surface = std::get<DooSabinSurface>(*result.patches);
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
    const DooSabinSurface& surface = std::get<DooSabinSurface>(*result.patches);
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

// The shortest way into several planes is a sum of their normals.
TEST(PlaneFaces, MovedVerticesOfSeveralPlanesGoTheShortestWay) {
  const PolygonMesh cube = LiftedCube(0.1);
  const HalfEdgeMesh mesh = oracle::BuildOrDie(cube);
  const oracle::Points given = oracle::FromVec3(cube.positions);
  for (const std::vector<Index>& planes :
       {std::vector<Index>{0}, {0, 2}, {0, 2, 4}, {0, 1, 2, 3, 4, 5}}) {
    LIMN_ASSERT_OK_AND_ASSIGN(const FeatureTable table,
                              MakeFeatureTable(Context{}, mesh, Planes(planes)));
    LIMN_ASSERT_OK_AND_ASSIGN(
        const Buffer<Vec3> moved,
        FlattenPlaneFaces(Context{}, mesh, table, {.points = cube.positions, .scale = 3.5}));
    for (std::size_t v = 0; v < 8; ++v) {
      oracle::Point rest = oracle::FromVec3({moved[v] - cube.positions[v]})[0];
      // What is left of it across the normals, made orthogonal one by one.
      oracle::Points used;
      for (const Index f : planes) {
        const absl::Span<const Index> face = cube.face(f);
        if (std::count(face.begin(), face.end(), static_cast<Index>(v)) == 0) continue;
        oracle::Points corners;
        for (const Index w : face) corners.push_back(given[w]);
        const oracle::Point middle = oracle::Centroid(corners);
        for (oracle::Point& p : corners) p = p - middle;
        oracle::Point normal = oracle::Equation10(corners);
        for (const oracle::Point& u : used) normal = normal - oracle::Dot(normal, u) * u;
        used.push_back(oracle::Unit(normal));
      }
      for (const oracle::Point& u : used) rest = rest - oracle::Dot(rest, u) * u;
      EXPECT_LE(oracle::Norm(rest), 1e-14L) << v << " of " << planes.size();
    }
  }
}

TEST(PlaneFaces, WhatHasNoPlaneIsRefused) {
  // A face on a line.
  PolygonMesh line = oracle::Cube();
  const absl::Span<const Index> face = line.face(3);
  for (std::size_t i = 0; i < 4; ++i) {
    line.positions[face[i]] = {static_cast<double>(i), 2 * static_cast<double>(i), 0};
  }
  oracle::ExpectError(Refusal(line, Planes({1, 3})),
                      {Reason::kInvalidOption, "constraints.features.faces[1].kind", 1});
  EXPECT_NE(Refusal(line, Planes({3})).message().find("face 3 has no plane"),
            std::string_view::npos);
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
  EXPECT_NE(status.message().find("around vertex"), std::string_view::npos) << status;
  oracle::ExpectError(status, {Reason::kInvalidOption, "constraints.features.default_face"});
  EXPECT_EQ(GetErrorDetail(status)->remedy, "Make some of them surface faces, or make them planar");
  std::vector<Index> backwards;
  for (auto f = static_cast<Index>(bent.face_count()); f-- > 0;) backwards.push_back(f);
  const absl::Status named = Refusal(bent, Planes(backwards));
  const std::uint64_t entry = GetErrorDetail(named)->index.value();
  oracle::ExpectError(named, {Reason::kInvalidOption,
                              absl::StrCat("constraints.features.faces[", entry, "].kind"), entry});
  // The vertex is of the entry's face.
  const std::string text(named.message());
  const Index vertex = static_cast<Index>(
      std::stoul(text.substr(text.find("around vertex ") + std::string("around vertex ").size())));
  const absl::Span<const Index> around = bent.face(backwards[entry]);
  EXPECT_EQ(std::count(around.begin(), around.end(), vertex), 1) << text;
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
  const BoundaryCurve& curve = std::get<DooSabinSurface>(*result.patches).boundary;
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

// A power of two changes no digit of the feet, only whether squares of lengths are numbers.
TEST(PlaneFaces, FeetOfTinyAndHugeModelsAreTheSame) {
  PolygonMesh cube = oracle::Cube();
  const FeatureValues values = Planes({0}, 0.3);
  const InterpolateResult usual = Made(cube, values, 0);
  const BoundaryCurve& expected = std::get<DooSabinSurface>(*usual.patches).boundary;
  for (const double factor : {0x1p-600, 0x1p+320}) {
    const InterpolateResult result = Made(oracle::Moved(cube, factor, {0, 0, 0}), values, 0);
    const BoundaryCurve& curve = std::get<DooSabinSurface>(*result.patches).boundary;
    ASSERT_EQ(curve.size(), expected.size());
    for (std::size_t i = 0; i < curve.size(); ++i) {
      EXPECT_LE(MaxAbs((1 / factor) * curve.start[i] - expected.start[i]), 1e-15) << factor;
      EXPECT_LE(MaxAbs((1 / factor) * curve.end[i] - expected.end[i]), 1e-15) << factor;
    }
  }
}

}  // namespace
}  // namespace limn
