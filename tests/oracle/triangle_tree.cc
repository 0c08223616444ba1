// SPDX-License-Identifier: MIT
#include "tests/oracle/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace limn::oracle {
namespace {

constexpr std::size_t kLeaf = 4;

double DistanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double square = Dot(along, along);
  const double t = square > 0 ? std::clamp(Dot(p - a, along) / square, 0.0, 1.0) : 0;
  return Norm(p - (a + t * along));
}

double DistanceToBox(const Vec3& p, const Vec3& low, const Vec3& high) {
  const auto outside = [](double x, double from, double to) {
    return std::max({from - x, x - to, 0.0});
  };
  return Norm(
      {outside(p.x, low.x, high.x), outside(p.y, low.y, high.y), outside(p.z, low.z, high.z)});
}

double Coordinate(const Vec3& p, std::size_t axis) {
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

}  // namespace

double DistanceToTriangle(const Vec3& p, const Triangle& triangle) {
  const auto& [a, b, c] = triangle;
  const Vec3 normal = Cross(b - a, c - a);
  const bool inside = Dot(normal, Cross(b - a, p - a)) > 0 &&
                      Dot(normal, Cross(c - b, p - b)) > 0 && Dot(normal, Cross(a - c, p - c)) > 0;
  if (inside) return std::fabs(Dot(normal, p - a)) / Norm(normal);
  return std::min(
      {DistanceToSegment(p, a, b), DistanceToSegment(p, b, c), DistanceToSegment(p, c, a)});
}

TriangleTree::TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  Build(0, triangles_.size());
}

std::size_t TriangleTree::Build(std::size_t begin, std::size_t end) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Node node = {{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}, begin, end, 0};
  for (std::size_t i = begin; i < end; ++i) {
    for (const Vec3& p : triangles_[i]) {
      node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
      node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y),
                   std::max(node.high.z, p.z)};
    }
  }
  const std::size_t number = nodes_.size();
  nodes_.push_back(node);
  if (end - begin <= kLeaf) return number;
  const Vec3 side = node.high - node.low;
  const std::size_t axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
  const auto middle = static_cast<std::ptrdiff_t>((begin + end) / 2);
  const auto first = triangles_.begin();
  std::nth_element(
      first + static_cast<std::ptrdiff_t>(begin), first + middle,
      first + static_cast<std::ptrdiff_t>(end), [&](const Triangle& a, const Triangle& b) {
        return Coordinate(a[0] + a[1] + a[2], axis) < Coordinate(b[0] + b[1] + b[2], axis);
      });
  Build(begin, static_cast<std::size_t>(middle));
  nodes_[number].right = Build(static_cast<std::size_t>(middle), end);
  return number;
}

double TriangleTree::Distance(const Vec3& p) const {
  double best = std::numeric_limits<double>::infinity();
  Search(0, p, &best);
  return best;
}

void TriangleTree::Search(std::size_t number, const Vec3& p, double* best) const {
  const Node& node = nodes_[number];
  if (DistanceToBox(p, node.low, node.high) >= *best) return;
  if (node.right == 0) {
    for (std::size_t i = node.begin; i < node.end; ++i) {
      *best = std::min(*best, DistanceToTriangle(p, triangles_[i]));
    }
    return;
  }
  const auto to = [&](std::size_t child) {
    return DistanceToBox(p, nodes_[child].low, nodes_[child].high);
  };
  const std::size_t left = number + 1;
  const bool left_first = to(left) <= to(node.right);
  Search(left_first ? left : node.right, p, best);
  Search(left_first ? node.right : left, p, best);
}

}  // namespace limn::oracle
