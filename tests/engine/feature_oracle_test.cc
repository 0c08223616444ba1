// SPDX-License-Identifier: MIT
// Surfaces with plane faces against meshes that are drawn out by the words of Xu and Kondo, section
// 3.2.2: the surface faces with the plane ones taken away, and each plane face alone, both with
// every mirrored image as a vertex, refined by the rule of closed meshes. Only where each corner
// has one surface face between its plane ones, as in the paper.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "engine/interpolate.h"
#include "tests/engine/feature_planes_testing.h"
#include "tests/oracle/expect.h"
#include "tests/oracle/features.h"
#include "tests/oracle/open_doo_sabin.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

struct OracleCase {
  std::string name;
  PolygonMesh mesh;
  std::vector<Index> planes;
};
void PrintTo(const OracleCase& c, std::ostream* out) { *out << c.name; }

// A part of the given mesh, with vertices of its own numbers.
struct Part {
  oracle::Mesh mesh;
  oracle::Wishes wishes;
  // Of the given mesh, by face of the part.
  std::vector<Index> face;
};

class FeatureOracle : public testing::TestWithParam<OracleCase> {
 protected:
  FeatureOracle()
      : planes_(GetParam().planes),
        built_(oracle::BuildOrDie(GetParam().mesh)),
        given_(oracle::FromPolygonMesh(GetParam().mesh)),
        values_(RandomValues(built_, 31)) {
    for (const Index f : planes_) values_.faces.push_back({f, FaceKind::kPlane});
    images_ = oracle::AllFeatureImages(given_, values_);
  }

  bool IsPlane(Index f) const { return std::count(planes_.begin(), planes_.end(), f) > 0; }

  std::size_t PlanesAround(Index v) const {
    std::size_t count = 0;
    for (const Index f : planes_) {
      const oracle::Face& face = given_.faces[f];
      count += static_cast<std::size_t>(std::count(face.begin(), face.end(), static_cast<int>(v)));
    }
    return count;
  }

  // The curve's point near the end of h that it leaves, or enters.
  oracle::Point CurvePoint(Index h, bool leaves) const {
    const PolygonWalk walk(built_);
    const Index twin = built_.twin()[h];
    const bool plane = IsPlane(built_.face()[h]);
    const oracle::Point a = given_.points[built_.vertex()[h]];
    const oracle::Point b = given_.points[built_.vertex()[walk.Next(h)]];
    if (plane && IsPlane(built_.face()[twin])) {
      return leaves ? 0.25L * (3 * a + b) : 0.25L * (a + 3 * b);
    }
    // The images of the surface face.
    const auto [from, to] = plane ? oracle::FeetOf(a, b, images_[walk.Next(twin)], images_[twin])
                                  : oracle::FeetOf(a, b, images_[h], images_[walk.Next(h)]);
    return leaves ? from : to;
  }

  // Where the curve around a plane face passes the vertex of its half-edge h.
  oracle::Point CentreAt(Index h) const {
    const Index v = built_.vertex()[h];
    if (PlanesAround(v) > 1) return given_.points[v];
    return 0.5L * (CurvePoint(h, true) + CurvePoint(PolygonWalk(built_).Prev(h), false));
  }

  Part PartOf(const std::vector<Index>& faces) const {
    Part part;
    const PolygonWalk walk(built_);
    std::vector<int> number(given_.points.size(), -1);
    for (const Index f : faces) {
      oracle::Face face;
      for (Index h = walk.FaceBegin(f); h < walk.FaceEnd(f); ++h) {
        int& v = number[built_.vertex()[h]];
        if (v < 0) {
          v = static_cast<int>(part.mesh.points.size());
          part.mesh.points.push_back(given_.points[built_.vertex()[h]]);
        }
        face.push_back(v);
        part.wishes.images.push_back(images_[h]);
      }
      part.mesh.faces.push_back(face);
      part.face.push_back(f);
    }
    part.wishes.interpolated.assign(part.mesh.points.size(), false);
    for (const Index f : faces) {
      for (Index h = walk.FaceBegin(f); h < walk.FaceEnd(f); ++h) {
        if (!IsPlane(f) && !IsPlane(built_.face()[built_.twin()[h]])) continue;
        const int a = number[built_.vertex()[h]];
        const int b = number[built_.vertex()[walk.Next(h)]];
        part.wishes.curve[{a, b}] = CurvePoint(h, true);
        part.wishes.curve[{b, a}] = CurvePoint(h, false);
      }
    }
    return part;
  }

  Part SurfaceFaces() const {
    std::vector<Index> faces;
    for (Index f = 0; f < given_.faces.size(); ++f) {
      if (!IsPlane(f)) faces.push_back(f);
    }
    return PartOf(faces);
  }

  Part PlaneFace(Index f) const {
    Part part = PartOf({f});
    const Index first = built_.face_begin()[f];
    for (std::size_t i = 0; i < part.mesh.points.size(); ++i) {
      part.mesh.points[i] = CentreAt(first + static_cast<Index>(i));
    }
    const oracle::Point mean = oracle::Centroid(part.mesh.points);
    for (std::size_t i = 0; i < part.mesh.points.size(); ++i) {
      part.wishes.images[i] = 0.5L * (part.mesh.points[i] + mean);
    }
    return part;
  }

  // The part's quads, one by one, are those of its faces in the surface.
  void ExpectIsIn(const Tessellation& surface, const Part& part) const {
    oracle::DooSabinMesh mesh = oracle::OpenFirstRefined(part.mesh, part.mesh.points, part.wishes);
    oracle::Tiling tiling = oracle::Split(oracle::TilingOf(part.mesh));
    std::size_t per_corner = 1;
    for (std::uint32_t k = 1; k < surface.level; ++k) {
      mesh = oracle::Refine(mesh, tiling);
      tiling = oracle::Split(tiling);
      per_corner *= 4;
    }
    const oracle::Points expected = oracle::LimitPoints(mesh, tiling);
    const oracle::Points found = oracle::FromVec3(surface.positions);
    std::size_t q = 0;
    for (const Index f : part.face) {
      const std::size_t first = built_.face_begin()[f] * per_corner;
      const std::size_t last = built_.face_begin()[f + 1] * per_corner;
      for (std::size_t own = first; own < last; ++own, ++q) {
        for (std::size_t i = 0; i < 4; ++i) {
          const oracle::Point p = found[surface.face_vertices[4 * own + i]];
          const oracle::Point e = expected[static_cast<std::size_t>(tiling.faces[q][i])];
          ASSERT_LE(oracle::Norm(p - e), 1e-13L * oracle::Diagonal(given_.points))
              << "face " << f << ", quad " << own;
        }
      }
    }
    EXPECT_EQ(q, tiling.faces.size());
  }

  const std::vector<Index> planes_;
  const HalfEdgeMesh built_;
  const oracle::Mesh given_;
  FeatureValues values_;
  // By corner, as if no face were plane.
  oracle::Points images_;
};

TEST_P(FeatureOracle, SurfacesAroundPlaneFacesAreThoseOfTheDrawnOutMesh) {
  for (const std::uint32_t level : {1U, 2U, 3U}) {
    const InterpolateResult result = Made(GetParam().mesh, values_, level);
    ExpectIsIn(result.surface, SurfaceFaces());
  }
}

TEST_P(FeatureOracle, PlaneRegionsAreThoseOfTheDrawnOutFace) {
  for (const std::uint32_t level : {1U, 2U, 3U}) {
    const InterpolateResult result = Made(GetParam().mesh, values_, level);
    for (const Index f : planes_) ExpectIsIn(result.surface, PlaneFace(f));
  }
}

// Three faces of a cube around a vertex.
std::vector<Index> AroundAVertex(const PolygonMesh& cube) {
  std::vector<Index> faces;
  for (Index f = 0; f < cube.face_count(); ++f) {
    const absl::Span<const Index> face = cube.face(f);
    if (std::count(face.begin(), face.end(), Index{0}) > 0) faces.push_back(f);
  }
  return faces;
}

std::vector<OracleCase> OracleCases() {
  return {{"cube_one", oracle::Cube(), {0}},
          {"cube_two", oracle::Cube(), {0, 1}},
          {"cube_neighbours", oracle::Cube(), {0, 2}},
          {"cube_around_a_vertex", oracle::Cube(), AroundAVertex(oracle::Cube())},
          {"octahedron", oracle::Octahedron(), {0}},
          {"dodecahedron", oracle::Dodecahedron(), {0, 3, 7}},
          {"prism", oracle::Prism(7), {0}},
          {"cone_base", Cone(6), {0}},
          {"cone_side", Cone(6), {2}},
          {"torus", oracle::TorusOfTriangles(7, 6), {0, 30}},
          {"genus_three", oracle::GenusThree(), {3}}};
}

INSTANTIATE_TEST_SUITE_P(All, FeatureOracle, testing::ValuesIn(OracleCases()),
                         [](const auto& c) { return c.param.name; });

}  // namespace
}  // namespace limn
