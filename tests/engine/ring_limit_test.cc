// SPDX-License-Identifier: MIT
// Masks of limit points and tangents: against the refinement of a ring of its own, and against the
// rings that deep refinement leaves.
#include "engine/limit/ring_limit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "engine/refine/loop_refine.h"
#include "tests/oracle/creases.h"
#include "tests/oracle/deep_limit.h"
#include "tests/oracle/test_meshes.h"

namespace limn {
namespace {

using oracle::CreasedMesh;
using oracle::Creases;
using oracle::DeepLimit;
using oracle::Point;
using oracle::Rule;

// A bump of mesh: vertex 0 among n quads, with another ring around.
PolygonMesh Star(std::size_t n) {
  PolygonMesh mesh;
  mesh.positions.push_back({0, 0, 0});
  const Index m = static_cast<Index>(n);
  for (Index ring = 1; ring <= 3; ++ring) {
    for (Index i = 0; i < m; ++i) {
      const double angle = 2 * std::numbers::pi * (i + (ring == 3 ? 0 : 0.5 * (ring - 1))) / m;
      const double radius = ring == 3 ? 3 : ring;
      mesh.positions.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), 0.1 * ring * std::sin(3 * angle)});
    }
  }
  for (Index i = 0; i < m; ++i) {
    const Index j = (i + 1) % m;
    mesh.AddFace(std::vector<Index>{0, 1 + i, 1 + m + i, 1 + j});
    mesh.AddFace(std::vector<Index>{1 + i, 1 + 2 * m + i, 1 + m + i});
    mesh.AddFace(std::vector<Index>{1 + j, 1 + m + i, 1 + 2 * m + j});
  }
  return mesh;
}

PolygonMesh StarFor(Rule rule, std::size_t n) {
  if (rule == Rule::kCatmullClark) return Star(n);
  // The n quads give way to n triangles.
  PolygonMesh star;
  star.positions = Star(n).positions;
  const Index m = static_cast<Index>(n);
  for (Index i = 0; i < m; ++i) {
    const Index j = (i + 1) % m;
    star.AddFace(std::vector<Index>{0, 1 + i, 1 + j});
    star.AddFace(std::vector<Index>{1 + i, 1 + m + i, 1 + j});
    star.AddFace(std::vector<Index>{1 + i, 1 + 2 * m + i, 1 + m + i});
    star.AddFace(std::vector<Index>{1 + j, 1 + m + i, 1 + 2 * m + j});
  }
  return star;
}

// The ring that deep refinement of a star leaves, for the engine.
VertexRing DeepRing(const PolygonMesh& star, Rule rule, const Creases& creases) {
  const CreasedMesh mesh = oracle::WithCreases(oracle::FromPolygonMesh(star), creases);
  const DeepLimit deep = oracle::RefineDeeply(mesh, rule, 0, 200);
  VertexRing ring;
  const auto to_vec3 = [](const Point& p) {
    return Vec3{static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
  };
  for (std::size_t i = 0; i < deep.ring.size(); ++i) {
    ring.edge.push_back(to_vec3(deep.ring[i]));
    ring.sharp.push_back(deep.sharp[i] ? 1 : 0);
    if (rule == Rule::kCatmullClark) ring.face.push_back(to_vec3(deep.across[i]));
  }
  return ring;
}
RingKind KindOf(Rule rule) { return rule == Rule::kLoop ? RingKind::kTriangles : RingKind::kQuads; }

// E_i ~ S + lambda^k (cos(2 pi i / n) u + sin(2 pi i / n) v).
TEST(RingLimit, SmoothTangentsAreScaledByTheEndsOfTheEdges) {
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    for (std::size_t n = 3; n <= 8; ++n) {
      SCOPED_TRACE(n);
      const VertexRing ring = DeepRing(StarFor(rule, n), rule, {});
      ASSERT_EQ(ring.edge.size(), n);
      const Tangents t = RingFrame(KindOf(rule), ring).tangents;
      for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
        EXPECT_LE(Norm(ring.edge[i] - (std::cos(angle) * t.u + std::sin(angle) * t.v)), 1e-6) << i;
      }
    }
  }
}

// In the widest part between two sharp edges: E_i ~ S + lambda^k sin(pi i / f) v.
TEST(RingLimit, CreaseTangentsAreScaledByTheEndsOfTheEdges) {
  for (const Rule rule : {Rule::kCatmullClark, Rule::kLoop}) {
    for (Index f = rule == Rule::kLoop ? 4 : 3; f <= 7; ++f) {
      SCOPED_TRACE(f);
      const Index n = f + 2;
      Creases creases;
      creases.indices = {1, 0, 1 + f};
      creases.lengths = {3};
      creases.sharpnesses = {kSharpForever};
      VertexRing ring = DeepRing(StarFor(rule, n), rule, creases);
      ASSERT_EQ(ring.edge.size(), n);
      if (ring.sharp[f] == 0) {
        std::rotate(ring.edge.begin(), ring.edge.begin() + 2, ring.edge.end());
        std::rotate(ring.sharp.begin(), ring.sharp.begin() + 2, ring.sharp.end());
        if (!ring.face.empty()) {
          std::rotate(ring.face.begin(), ring.face.begin() + 2, ring.face.end());
        }
      }
      ASSERT_NE(ring.sharp[f], 0);
      const Vec3 v = RingFrame(KindOf(rule), ring).tangents.v;
      EXPECT_GT(Norm(v), 0.1);
      for (Index i = 0; i <= f; ++i) {
        EXPECT_LE(Norm(ring.edge[i] - std::sin(std::numbers::pi * i / f) * v), 1e-2) << i;
      }
    }
  }
}

// A boundary vertex of f quads or triangles of random shape: published masks, which fit few faces.
TEST(RingLimit, BoundariesOfFewFacesHaveThePublishedMasks) {
  VertexRing ring;
  ring.closed = false;
  const Vec3 p[] = {{1, 0.2, 0}, {0.7, 0.9, 0.1}, {-0.4, 1.1, -0.2}, {-1, 0.1, 0.3}};
  const Vec3 q[] = {{1.1, 1, 0.4}, {-0.9, 1.2, 0.2}};
  // Two quads: the derivative of a bicubic B-spline across its regular boundary.
  ring.edge = {p[0], p[1], p[3]};
  ring.face = {q[0], q[1]};
  ring.sharp = {1, 0, 1};
  VertexFrame frame = RingFrame(RingKind::kQuads, ring);
  EXPECT_LE(MaxAbs(frame.point - (1 / 6.0) * (p[0] + p[3])), 1e-15);
  EXPECT_LE(MaxAbs(frame.tangents.u - 0.5 * (p[0] - p[3])), 1e-15);
  EXPECT_LE(MaxAbs(frame.tangents.v - (1 / 6.0) * (4 * p[1] - p[0] - p[3] + q[0] + q[1])), 1e-15);
  // Three triangles: that of a quartic box spline. Two: E_1 - V. One: the bend of the curve.
  ring.edge = {p[0], p[1], p[2], p[3]};
  ring.face.clear();
  ring.sharp = {1, 0, 0, 1};
  frame = RingFrame(RingKind::kTriangles, ring);
  EXPECT_LE(MaxAbs(frame.tangents.v - (std::sqrt(3.0) / 6) * (2 * (p[1] + p[2]) - p[0] - p[3])),
            1e-15);
  ring.edge = {p[0], p[1], p[3]};
  ring.sharp = {1, 0, 1};
  EXPECT_LE(MaxAbs(RingFrame(RingKind::kTriangles, ring).tangents.v - p[1]), 1e-15);
  ring.edge = {p[0], p[3]};
  ring.sharp = {1, 1};
  EXPECT_LE(MaxAbs(RingFrame(RingKind::kTriangles, ring).tangents.v - (p[0] + p[3])), 1e-15);
}

// What a ring refines to, by the textbooks.
VertexRing RefinedRing(RingKind kind, const VertexRing& ring) {
  const std::size_t n = ring.edge.size();
  const std::size_t faces = ring.closed ? n : n - 1;
  VertexRing next = ring;
  Vec3 edges = {0, 0, 0};
  Vec3 sharp_ends = {0, 0, 0};
  std::size_t sharp = 0;
  for (std::size_t i = 0; i < n; ++i) {
    edges += ring.edge[i];
    if (ring.sharp[i] != 0) {
      sharp_ends += ring.edge[i];
      ++sharp;
    }
  }
  std::vector<Vec3> centroid(faces);
  Vec3 centroids = {0, 0, 0};
  for (std::size_t i = 0; i < faces; ++i) {
    if (kind == RingKind::kQuads) {
      centroid[i] = 0.25 * (ring.edge[i] + ring.edge[(i + 1) % n] + ring.face[i]);
      centroids += centroid[i];
    }
  }
  const double m = static_cast<double>(n);
  Vec3 moved = {0, 0, 0};
  if (ring.corner || sharp > 2) {
    moved = {0, 0, 0};
  } else if (sharp == 2) {
    moved = 0.125 * sharp_ends;
  } else if (kind == RingKind::kQuads) {
    moved = (1 / m) * ((1 / m) * centroids + (1 / m) * edges);
  } else {
    moved = (LoopNeighbourWeight(n) / m) * edges;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& own = ring.edge[i];
    if (ring.sharp[i] != 0) {
      next.edge[i] = 0.5 * own - moved;
    } else if (kind == RingKind::kQuads) {
      next.edge[i] = 0.25 * (own + centroid[i] + centroid[(i + n - 1) % n]) - moved;
    } else {
      next.edge[i] =
          0.375 * own + 0.125 * (ring.edge[(i + 1) % n] + ring.edge[(i + n - 1) % n]) - moved;
    }
  }
  for (std::size_t i = 0; i < ring.face.size(); ++i) next.face[i] = centroid[i] - moved;
  next.point = ring.point + moved;
  return next;
}

// A ring of n edges with these sharp ones, at random places.
VertexRing RandomRing(RingKind kind, std::size_t n, const std::vector<std::size_t>& sharp) {
  std::mt19937_64 random(n);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  const auto point = [&] {
    return Vec3{coordinate(random), coordinate(random), coordinate(random)};
  };
  VertexRing ring;
  ring.point = point();
  for (std::size_t i = 0; i < n; ++i) {
    ring.edge.push_back(point());
    ring.sharp.push_back(0);
    if (kind == RingKind::kQuads) ring.face.push_back(point());
  }
  for (const std::size_t i : sharp) ring.sharp[i] = 1;
  return ring;
}

// after = eigenvalue before; returns the eigenvalue.
double ExpectScaled(const Vec3& before, const Vec3& after) {
  const double ratio = Dot(after, before) / Dot(before, before);
  EXPECT_LE(Norm(after - ratio * before), 1e-12 * Norm(before));
  return ratio;
}

// All valences, against the refinement of a ring of its own.
TEST(RingLimit, MasksAreLeftEigenvectorsForEveryValence) {
  for (const RingKind kind : {RingKind::kQuads, RingKind::kTriangles}) {
    const std::size_t widest = kind == RingKind::kQuads ? 2 : 3;
    for (const std::size_t n : {2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 20, 37, 100, 1001}) {
      SCOPED_TRACE(n);
      const auto check = [&](const std::vector<std::size_t>& sharp, double u_value,
                             double v_value) {
        const VertexRing ring = RandomRing(kind, n, sharp);
        const VertexRing refined = RefinedRing(kind, ring);
        const VertexFrame before = RingFrame(kind, ring);
        const VertexFrame after = RingFrame(kind, refined);
        EXPECT_LE(Norm(before.point - after.point), 1e-14);
        EXPECT_EQ(RingPoint(kind, ring), before.point);
        const double u = ExpectScaled(before.tangents.u, after.tangents.u);
        if (u_value > 0) {
          EXPECT_NEAR(u, u_value, 1e-13);
        }
        if (kind == RingKind::kTriangles && n == 2) return u;
        EXPECT_NEAR(ExpectScaled(before.tangents.v, after.tangents.v), v_value, 1e-13);
        return u;
      };
      const double wave = WaveOf(kind, 2 * std::numbers::pi / static_cast<double>(n)).eigenvalue;
      check({}, wave, wave);
      const double dart = check({1}, -1, wave);
      // Between the smooth one and that of the sharp edge itself.
      EXPECT_GE(dart, std::min(wave, 0.5) - 1e-13);
      EXPECT_LE(dart, std::max(wave, 0.5) + 1e-13);
      for (const std::size_t f : {n / 2, n - 1}) {
        if (f < 2) continue;
        const double sector = WaveOf(kind, std::numbers::pi / static_cast<double>(f)).eigenvalue;
        check({0, f}, 0.5, sector);
        if (f <= widest) continue;
        // The corner's own tangents are those of its curves.
        VertexRing ring = RandomRing(kind, n, {0, f});
        ring.corner = true;
        const SectorMask mask = CornerMask(kind, f);
        const auto across = [&](const VertexRing& r) {
          Vec3 sum = mask.ends * (r.edge[0] + r.edge[f]);
          for (std::size_t i = 0; i < f; ++i) {
            const double a = std::numbers::pi / static_cast<double>(f);
            const double at = static_cast<double>(i);
            sum += mask.edge * std::sin(at * a) * r.edge[i];
            if (kind == RingKind::kQuads) sum += mask.face * std::sin((at + 0.5) * a) * r.face[i];
          }
          return sum;
        };
        EXPECT_NEAR(ExpectScaled(across(ring), across(RefinedRing(kind, ring))), sector, 1e-13);
      }
    }
  }
}

TEST(RingLimit, CuspsSlitsAndFoldsHaveTheAnswersOfTheHeader) {
  // A sharp vertex among smooth edges.
  VertexRing ring = RandomRing(RingKind::kQuads, 5, {});
  const VertexFrame smooth = RingFrame(RingKind::kQuads, ring);
  ring.corner = true;
  const VertexFrame cusp = RingFrame(RingKind::kQuads, ring);
  EXPECT_EQ(cusp.point, ring.point);
  EXPECT_EQ(cusp.tangents.u, smooth.tangents.u);
  EXPECT_EQ(cusp.normal, smooth.normal);
  // The sharp end of a single sharp edge: the planes at its two sides cancel.
  ring.sharp[2] = 1;
  EXPECT_EQ(RingFrame(RingKind::kQuads, ring).normal, (Vec3{0, 0, 0}));
  // A sheet folded flat along its crease.
  VertexRing fold;
  fold.edge = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 1, 0}};
  fold.face = {{1, 1, 0}, {-1, 1, 0}, {-1, 1, 0}, {1, 1, 0}};
  fold.sharp = {1, 0, 1, 0};
  EXPECT_EQ(RingFrame(RingKind::kQuads, fold).normal, (Vec3{0, 0, 0}));
  // Valence 2: u along the edges, v from one face to the other.
  VertexRing two = RandomRing(RingKind::kQuads, 2, {});
  const VertexFrame pillow = RingFrame(RingKind::kQuads, two);
  EXPECT_LE(MaxAbs(pillow.tangents.u - 0.5 * (two.edge[0] - two.edge[1])), 1e-15);
  EXPECT_LE(MaxAbs(pillow.tangents.v - 0.5 * (two.face[0] - two.face[1])), 1e-15);
  EXPECT_EQ(RingFrame(RingKind::kTriangles, RandomRing(RingKind::kTriangles, 2, {})).normal,
            (Vec3{0, 0, 0}));
}

// Corners whose planes tend to that of the two curves like 1 / k only: what is given is the mean of
// the planes at both ends, that of the curve and `across`, whose refinement is half of it and a
// share of both curves.
TEST(RingLimit, NarrowCornersHaveTheMeanOfThePlanesAtBothEnds) {
  for (const RingKind kind : {RingKind::kQuads, RingKind::kTriangles}) {
    for (const bool regular : {true, false}) {
      // Two quads, three triangles; two triangles with straight curves.
      const bool quads = kind == RingKind::kQuads;
      if (quads && !regular) continue;
      VertexRing ring;
      ring.closed = false;
      ring.corner = true;
      ring.edge = {{1, 0.2, 0}, {0.7, 0.9, 0.3}, {-0.9, 0.1, 0.3}};
      if (quads) ring.face = {{1.1, 1, 0.4}, {-0.9, 1.2, 0.2}};
      if (!quads && regular) ring.edge.insert(ring.edge.begin() + 2, {-0.4, 1.1, -0.2});
      if (!regular) ring.edge.back() = -1.5 * ring.edge.front();
      ring.sharp.assign(ring.edge.size(), 0);
      ring.sharp.front() = ring.sharp.back() = 1;
      const auto across = [&](const VertexRing& r) -> Vec3 {
        if (quads) return (2 / 3.0) * r.edge[1] + (1 / 6.0) * (r.face[0] + r.face[1]);
        return regular ? (1 / std::sqrt(3.0)) * (r.edge[1] + r.edge[2]) : r.edge[1];
      };
      const VertexRing refined = RefinedRing(kind, ring);
      const double value = regular ? 0.5 : 0.375;
      const double share = quads ? 1 / 12.0 : (regular ? 0.125 / std::sqrt(3.0) : 0.125);
      EXPECT_LE(Norm(across(refined) - value * across(ring) -
                     share * (ring.edge.front() + ring.edge.back())),
                1e-15);
      const Vec3 v = across(ring);
      const Vec3 normal = NormalizedOrZero(NormalizedOrZero(Cross(ring.edge.front(), v)) +
                                           NormalizedOrZero(Cross(v, ring.edge.back())));
      EXPECT_LE(Norm(RingFrame(kind, ring).normal - normal), 1e-14);
    }
  }
}

// A flat sheet is flat also at a sharp vertex on its straight side, and at the corner of one quad
// whose sides form a line.
TEST(RingLimit, StraightSidesDoNotSpoilNormals) {
  for (const double bend : {0.0, 1e-12, 1e-5}) {
    SCOPED_TRACE(bend);
    VertexRing ring;
    ring.closed = false;
    ring.edge = {{1, 0, bend}, {0, 1, 0}, {-1, 0, bend}};
    ring.face = {{1, 1, 0}, {-1, 1, 0}};
    ring.sharp = {1, 0, 1};
    for (const bool corner : {false, true}) {
      ring.corner = corner;
      EXPECT_LE(Norm(RingFrame(RingKind::kQuads, ring).normal - Vec3{0, 0, 1}), 1e-4);
    }
    VertexRing one;
    one.closed = false;
    one.edge = {{1, 0, bend}, {-1, 0, bend}};
    one.face = {{0, 1, 0}};
    one.sharp = {1, 1};
    for (const bool corner : {false, true}) {
      one.corner = corner;
      EXPECT_LE(Norm(RingFrame(RingKind::kQuads, one).normal - Vec3{0, 0, 1}), 1e-4);
    }
    VertexRing triangles;
    triangles.closed = false;
    triangles.edge = {{1, 0, bend}, {0.5, 0.9, 0}, {-0.5, 0.9, 0}, {-1, 0, bend}};
    triangles.sharp = {1, 0, 0, 1};
    for (const bool corner : {false, true}) {
      triangles.corner = corner;
      EXPECT_LE(Norm(RingFrame(RingKind::kTriangles, triangles).normal - Vec3{0, 0, 1}), 1e-4);
    }
  }
}

}  // namespace
}  // namespace limn
