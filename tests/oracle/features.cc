// SPDX-License-Identifier: MIT
#include "tests/oracle/features.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace limn::oracle {
namespace {

constexpr Real kPi = std::numbers::pi_v<Real>;

struct Line {
  Point through;
  Point along;
};

// The middle of the shortest segment between two lines that are not parallel.
Point Meeting(const Line& a, const Line& b) {
  const Point d = b.through - a.through;
  const Real aa = Dot(a.along, a.along);
  const Real bb = Dot(b.along, b.along);
  const Real ab = Dot(a.along, b.along);
  const Real det = ab * ab - aa * bb;
  const Real s = (ab * Dot(d, b.along) - bb * Dot(d, a.along)) / det;
  const Real t = (aa * Dot(d, b.along) - ab * Dot(d, a.along)) / det;
  return 0.5L * ((a.through + s * a.along) + (b.through + t * b.along));
}

}  // namespace

Points FeatureCrossings(const Points& face, const std::vector<Real>& edge) {
  const std::size_t m = face.size();
  const Point c = Centroid(face);
  Points crossings;
  for (std::size_t i = 0; i < m; ++i) {
    const std::size_t before = (i + m - 1) % m;
    const Point& v = face[i];
    const Point next = face[(i + 1) % m] - v;
    const Point previous = face[before] - v;
    const Point middle = v + (edge[before] + edge[i]) / 2 * (c - v);
    const Real sine = Norm(Cross(Unit(next), Unit(previous)));
    if (sine < 1e-9L) {
      crossings.push_back(middle);
      continue;
    }
    const Line own = {v + edge[i] * (c - v), next};
    const Line other = {v + edge[before] * (c - v), previous};
    const Point meeting = Meeting(own, other);
    crossings.push_back(middle + std::min(1.0L, 64 * sine * sine) * (meeting - middle));
  }
  return crossings;
}

Points InSequence(const Points& face, Points crossings) {
  const auto m = static_cast<int>(face.size());
  const Point c = Centroid(face);
  Point normal;
  for (std::size_t i = 0; i < face.size(); ++i) {
    normal = normal + Cross(face[i] - c, face[(i + 1) % face.size()] - c);
  }
  if (Norm(normal) == 0) return crossings;
  normal = Unit(normal);
  const Point x = Unit(Cross(std::fabs(normal.x) < 0.5L ? Point{1, 0, 0} : Point{0, 1, 0}, normal));
  const Point y = Cross(normal, x);
  const auto angle = [&](const Point& p) { return std::atan2(Dot(p, y), Dot(p, x)); };
  const auto radius = [&](const Point& p) { return std::hypot(Dot(p, y), Dot(p, x)); };
  // The nearest turn of `a` to `to`.
  const auto near = [](Real a, Real to) { return a - 2 * kPi * std::round((a - to) / (2 * kPi)); };
  std::vector<Real> own;
  for (int i = 0; i < m; ++i) {
    const Real raw = angle(face[static_cast<std::size_t>(i)] - c);
    if (i == 0) {
      own.push_back(raw);
      continue;
    }
    own.push_back(near(raw, own.back()));
    if (!(own.back() > own[static_cast<std::size_t>(i) - 1])) return crossings;
  }
  // Once around, and on to the first vertex again.
  const Real last = near(own[0], own.back());
  if (!(last > own.back()) || std::fabs(last - own[0] - 2 * kPi) > 1e-6L) return crossings;
  std::vector<std::pair<Real, Point>> slots;
  for (std::size_t i = 0; i < face.size(); ++i) {
    const Point p = crossings[i] - c;
    const bool none = radius(p) <= 1e-12L * radius(face[i] - c);
    slots.emplace_back(none ? own[i] : near(angle(p), own[i]), crossings[i]);
  }
  // Neighbours change places until none is wrong. Past the last comes the first, a turn on.
  bool wrong = true;
  while (wrong) {
    wrong = false;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const std::size_t next = (i + 1) % slots.size();
      const Real turn = next == 0 ? 2 * kPi : 0;
      if (slots[i].first <= slots[next].first + turn + 1e-11L) continue;
      std::swap(slots[i], slots[next]);
      slots[i].first += turn;
      slots[next].first -= turn;
      wrong = true;
    }
  }
  for (std::size_t i = 0; i < slots.size(); ++i) crossings[i] = slots[i].second;
  return crossings;
}

Points FeatureImages(const Points& face, const std::vector<Real>& edge,
                     const std::vector<Real>& vertex) {
  Points images = InSequence(face, FeatureCrossings(face, edge));
  for (std::size_t i = 0; i < face.size(); ++i) {
    images[i] = face[i] + vertex[i] * (images[i] - face[i]);
  }
  return images;
}

Real EdgeValueOf(const FeatureValues& values, int face, int from, int to) {
  std::optional<double> of_edge;
  for (const EdgeFeature& e : values.edges) {
    if (EdgeKey(static_cast<int>(e.from), static_cast<int>(e.to)) != EdgeKey(from, to)) continue;
    if (!e.face.has_value()) of_edge = e.value;
    if (e.face == static_cast<Index>(face)) return e.value;
  }
  return of_edge.value_or(values.default_edge);
}

Real VertexValueOf(const FeatureValues& values, int face, int vertex) {
  std::optional<double> of_vertex;
  for (const VertexFeature& v : values.vertices) {
    if (static_cast<int>(v.vertex) != vertex) continue;
    if (!v.face.has_value()) of_vertex = v.value;
    if (v.face == static_cast<Index>(face)) return v.value;
  }
  return of_vertex.value_or(values.default_vertex);
}

Points AllFeatureImages(const Mesh& given, const FeatureValues& values) {
  Points all;
  for (std::size_t f = 0; f < given.faces.size(); ++f) {
    const Face& face = given.faces[f];
    Points points;
    std::vector<Real> edge;
    std::vector<Real> vertex;
    for (std::size_t i = 0; i < face.size(); ++i) {
      points.push_back(given.points[static_cast<std::size_t>(face[i])]);
      edge.push_back(
          EdgeValueOf(values, static_cast<int>(f), face[i], face[(i + 1) % face.size()]));
      vertex.push_back(VertexValueOf(values, static_cast<int>(f), face[i]));
    }
    for (const Point& image : FeatureImages(points, edge, vertex)) all.push_back(image);
  }
  return all;
}

FeatureTiling FeatureLimit(const Mesh& given, const FeatureValues& values, int level) {
  Tiling tiling = TilingOf(given);
  // The step's vertices are the images, face by face.
  DooSabinMesh mesh = RefineFirst(Start(given), tiling);
  mesh.points = AllFeatureImages(given, values);
  tiling = Split(tiling);
  for (int k = 1; k < level; ++k) {
    mesh = Refine(mesh, tiling);
    tiling = Split(tiling);
  }
  return {tiling, LimitPoints(mesh, tiling)};
}

std::pair<Point, Point> FeetOf(const Point& a, const Point& b, const Point& of_a,
                               const Point& of_b) {
  const Point e = b - a;
  const auto share = [&](const Point& p) {
    return std::clamp(Dot(p - a, e) / Dot(e, e), Real{0}, Real{1});
  };
  Real s = share(of_a);
  Real t = share(of_b);
  if (s > t) s = t = (s + t) / 2;
  return {a + s * e, a + t * e};
}

}  // namespace limn::oracle
