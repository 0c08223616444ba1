// SPDX-License-Identifier: MIT
#include "tests/oracle/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limn::oracle {

Point operator+(const Point& a, const Point& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Point operator-(const Point& a, const Point& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Point operator*(Real s, const Point& a) { return {s * a.x, s * a.y, s * a.z}; }
Real Dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Point Cross(const Point& a, const Point& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// The exponents of long double leave room for squares of any double.
Real Norm(const Point& a) { return std::sqrt(Dot(a, a)); }

Point Unit(const Point& a) {
  const Real norm = Norm(a);
  return norm == 0 ? Point{} : (1 / norm) * a;
}

Mesh FromPolygonMesh(const PolygonMesh& mesh) {
  Mesh result;
  result.points = FromVec3(mesh.positions);
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    Face face;
    for (const Index v : mesh.face(f)) face.push_back(static_cast<int>(v));
    result.faces.push_back(face);
  }
  return result;
}

Points FromVec3(absl::Span<const Vec3> points) {
  Points result;
  for (const Vec3& p : points) result.push_back({p.x, p.y, p.z});
  return result;
}

std::pair<int, int> EdgeKey(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

EdgeNumbers NumberEdges(const std::vector<Face>& faces) {
  EdgeNumbers numbers;
  for (const Face& face : faces) {
    for (std::size_t i = 0; i < face.size(); ++i) {
      // emplace leaves edges that are there already as they are.
      numbers.emplace(EdgeKey(face[i], face[(i + 1) % face.size()]),
                      static_cast<int>(numbers.size()));
    }
  }
  return numbers;
}

Point Centroid(const Points& polygon) {
  Point sum;
  for (const Point& p : polygon) sum = sum + p;
  return (1 / static_cast<Real>(polygon.size())) * sum;
}

Real Diagonal(const Points& points) {
  Point low = points.at(0);
  Point high = low;
  for (const Point& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return Norm(high - low);
}

Real MaxDistance(const Points& a, const Points& b) {
  if (a.size() != b.size()) return std::numeric_limits<Real>::infinity();
  Real largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Real distance = Norm(a[i] - b[i]);
    // Written so that a distance that is not a number counts.
    if (!(distance <= largest)) {
      largest = std::isnan(distance) ? std::numeric_limits<Real>::infinity() : distance;
    }
  }
  return largest;
}

}  // namespace limn::oracle
