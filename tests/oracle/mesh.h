// SPDX-License-Identifier: MIT
// The oracle's own mesh: lists of lists and long doubles, so that nothing of the engine's layout or
// arithmetic is shared with what it is held against.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "absl/types/span.h"
#include "engine/base/vec3.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::oracle {

using Real = long double;

struct Point {
  Real x = 0;
  Real y = 0;
  Real z = 0;
};

Point operator+(const Point& a, const Point& b);
Point operator-(const Point& a, const Point& b);
Point operator*(Real s, const Point& a);
Real Dot(const Point& a, const Point& b);
Point Cross(const Point& a, const Point& b);
Real Norm(const Point& a);
// a / |a|, or zero where |a| is zero.
Point Unit(const Point& a);

using Points = std::vector<Point>;
// Vertices of a face, counter-clockwise.
using Face = std::vector<int>;

struct Mesh {
  Points points;
  std::vector<Face> faces;
};

Mesh FromPolygonMesh(const PolygonMesh& mesh);
Points FromVec3(absl::Span<const Vec3> points);

// Undirected edges, each with its number in the order of first occurrence when the faces' sides are
// walked.
using EdgeNumbers = std::map<std::pair<int, int>, int>;
EdgeNumbers NumberEdges(const std::vector<Face>& faces);
std::pair<int, int> EdgeKey(int a, int b);

Point Centroid(const Points& polygon);

// Diagonal of the bounding box.
Real Diagonal(const Points& points);

// Largest distance between points of the same number; the sizes must be equal.
Real MaxDistance(const Points& a, const Points& b);

}  // namespace limn::oracle
