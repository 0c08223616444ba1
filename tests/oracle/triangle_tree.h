// SPDX-License-Identifier: MIT
// Distances to a set of triangles, by a tree of boxes.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "engine/base/vec3.h"

namespace limn::oracle {

using Triangle = std::array<Vec3, 3>;

// The distance of a point to the nearest point of a triangle.
double DistanceToTriangle(const Vec3& p, const Triangle& triangle);

class TriangleTree {
 public:
  explicit TriangleTree(std::vector<Triangle> triangles);
  // The distance to the nearest triangle.
  double Distance(const Vec3& p) const;

 private:
  struct Node {
    Vec3 low;
    Vec3 high;
    // Triangles of a leaf, or the right child of an inner node, whose left one follows it.
    std::size_t begin;
    std::size_t end;
    std::size_t right;
  };
  std::size_t Build(std::size_t begin, std::size_t end);
  void Search(std::size_t node, const Vec3& p, double* best) const;

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace limn::oracle
