// SPDX-License-Identifier: MIT
// Plane faces of meshes as files have them: turned, rounded, far away, with coplanar neighbours,
// thin triangles and edges without length.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/constraints/feature_planes.h"
#include "engine/mesh/validate.h"
#include "tests/engine/feature_planes_testing.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

// Turned about no axis of anything.
PolygonMesh Turned(PolygonMesh mesh) {
  const Vec3 x = NormalizedOrZero({0.37, 0.45, -0.81});
  const Vec3 y = NormalizedOrZero(Cross({0.2, 0.9, 0.4}, x));
  const Vec3 z = Cross(x, y);
  for (Vec3& p : mesh.positions) p = p.x * x + p.y * y + p.z * z;
  return mesh;
}

PolygonMesh Rounded(PolygonMesh mesh, int decimals) {
  const double unit = std::pow(10, decimals);
  const auto round = [&](double a) { return std::round(a * unit) / unit; };
  for (Vec3& p : mesh.positions) p = {round(p.x), round(p.y), round(p.z)};
  return mesh;
}

PolygonMesh Both(PolygonMesh mesh, const PolygonMesh& other) {
  const auto first = static_cast<Index>(mesh.vertex_count());
  for (const Vec3& p : other.positions) mesh.positions.push_back(p + Vec3{20, 0, 0});
  for (std::size_t f = 0; f < other.face_count(); ++f) {
    Buffer<Index> face;
    for (const Index v : other.face(f)) face.push_back(first + v);
    mesh.AddFace(face);
  }
  return mesh;
}

absl::StatusOr<Buffer<Vec3>> Flattened(const PolygonMesh& given, const FeatureValues& values) {
  const Context context;
  const HalfEdgeMesh mesh = oracle::BuildOrDie(given);
  absl::StatusOr<FeatureTable> table = MakeFeatureTable(context, mesh, values);
  if (!table.ok()) return table.status();
  BoundingBox box;
  const absl::Status status = ValidatePositions(context, given.positions, &box);
  if (!status.ok()) return status;
  return FlattenPlaneFaces(context, mesh, *table,
                           {.points = given.positions, .scale = box.diagonal()});
}

// Cubes side by side: each face of the whole is cut into several, which are coplanar.
PolygonMesh Bar() { return oracle::CubesSurface({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}); }

// The furthest of a region's points from the plane of three corners of its face.
double Bulge(const PolygonMesh& mesh, const Tessellation& surface) {
  const auto vertices = VerticesByFace(mesh, surface);
  double bulge = 0;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const absl::Span<const Index> face = mesh.face(f);
    const auto corner = [&](std::size_t i) { return surface.positions[face[i]]; };
    const Vec3 normal = NormalizedOrZero(Cross(corner(1) - corner(0), corner(2) - corner(0)));
    for (const Index v : vertices[f]) {
      bulge = std::max(bulge, std::fabs(Dot(normal, surface.positions[v] - corner(0))));
    }
  }
  return bulge;
}

TEST(FlattenedFaces, CoplanarNeighboursMayBeRounded) {
  for (const int decimals : {9, 6, 4}) {
    const PolygonMesh bar = Rounded(Turned(Bar()), decimals);
    const InterpolateResult result = Made(bar, {.default_face = FaceKind::kPlane}, 2);
    EXPECT_LE(Bulge(bar, result.surface), 1e-12) << decimals;
    // By no more than a few roundings.
    double furthest = 0;
    for (std::size_t v = 0; v < bar.vertex_count(); ++v) {
      furthest = std::max(furthest, Norm(result.surface.positions[v] - bar.positions[v]));
    }
    EXPECT_GT(furthest, 0) << decimals;
    EXPECT_LE(furthest, 4 * std::pow(10, -decimals));
  }
}

TEST(FlattenedFaces, CoplanarNeighboursMayBeFarFromTheOrigin) {
  for (const double far : {1e5, 1e6}) {
    const PolygonMesh bar = oracle::Moved(Turned(Bar()), 1, {far, -0.7 * far, 0.3 * far});
    const InterpolateResult result = Made(bar, {.default_face = FaceKind::kPlane}, 1);
    EXPECT_LE(Bulge(bar, result.surface), 8e-16 * far) << far;
  }
}

// Quads in a row, each turned against the last one.
PolygonMesh Arc(int columns, double turn) {
  PolygonMesh arc;
  Vec3 at = {0, 0, 0};
  for (int i = 0; i <= columns; ++i) {
    arc.positions.push_back(at);
    arc.positions.push_back(at + Vec3{0, 1, 0});
    at += Vec3{std::cos(i * turn), 0, std::sin(i * turn)};
  }
  for (int i = 0; i < columns; ++i) {
    const auto first = static_cast<Index>(2 * i);
    arc.AddFace({first, first + 2, first + 3, first + 1});
  }
  return arc;
}

TEST(FlattenedFaces, SmallTurnsThatAddUpAreNotMadeOnePlane) {
  const FeatureValues planes = {.default_face = FaceKind::kPlane};
  // Nothing happens to those that are planar.
  LIMN_ASSERT_OK_AND_ASSIGN(const Buffer<Vec3> exact, Flattened(Arc(12, 0.9e-3), planes));
  EXPECT_TRUE(exact.empty());
  LIMN_ASSERT_OK_AND_ASSIGN(const Buffer<Vec3> few,
                            Flattened(Rounded(Turned(Arc(3, 0.9e-3)), 6), planes));
  EXPECT_FALSE(few.empty());
  const absl::Status many = Flattened(Rounded(Turned(Arc(12, 0.9e-3)), 6), planes).status();
  oracle::ExpectError(many, {Reason::kInvalidOption, "constraints.features.faces"});
  EXPECT_TRUE(Flattened(Rounded(Turned(Arc(12, 0.1)), 6), planes).ok());
}

TEST(FlattenedFaces, TrianglesMoveNoVertexHoweverThin) {
  const PolygonMesh thin = Turned(oracle::DoublePyramid(100000));
  LIMN_ASSERT_OK_AND_ASSIGN(const Buffer<Vec3> moved,
                            Flattened(thin, {.default_face = FaceKind::kPlane}));
  EXPECT_TRUE(moved.empty());
}

TEST(FlattenedFaces, VerticesInAllTheirPlanesStayToTheBit) {
  const PolygonMesh planar = Both(Turned(oracle::Dodecahedron()), Turned(Cone(40)));
  PolygonMesh bent = oracle::Cube();
  bent.positions[0] = bent.positions[0] + Vec3{0.1, 0.1, 0.1};
  const PolygonMesh mesh = Both(planar, bent);
  LIMN_ASSERT_OK_AND_ASSIGN(const Buffer<Vec3> moved,
                            Flattened(mesh, {.default_face = FaceKind::kPlane}));
  ASSERT_EQ(moved.size(), mesh.vertex_count());
  for (std::size_t v = 0; v < planar.vertex_count(); ++v) {
    ASSERT_EQ(moved[v], planar.positions[v]) << v;
  }
  // So they may be interpolated.
  InterpolateOptions options = {.level = 0};
  options.constraints.features = FeatureValues{.default_face = FaceKind::kPlane};
  options.constraints.interpolate.emplace();
  for (Index v = 0; v < planar.vertex_count(); ++v) options.constraints.interpolate->push_back(v);
  LIMN_ASSERT_OK_AND_ASSIGN(const InterpolateResult result, Interpolate(Context{}, mesh, options));
  for (std::size_t v = 0; v < planar.vertex_count(); ++v) {
    ASSERT_EQ(result.surface.positions[v], mesh.positions[v]) << v;
  }
}

TEST(FlattenedFaces, EdgesWithoutLengthDoNotHoldVertices) {
  PolygonMesh prism = oracle::Prism(5);
  const absl::Span<const Index> top = prism.face(0);
  prism.positions[top[0]].z += 0.01;
  prism.positions[top[1]] = prism.positions[top[0]];
  LIMN_ASSERT_OK_AND_ASSIGN(const Buffer<Vec3> moved, Flattened(prism, Planes({0})));
  ASSERT_EQ(moved.size(), prism.vertex_count());
  EXPECT_EQ(moved[top[0]], moved[top[1]]);
  EXPECT_GT(Norm(moved[top[0]] - prism.positions[top[0]]), 1e-4);
}

}  // namespace
}  // namespace limn
