// SPDX-License-Identifier: MIT
// Feature values from the words of Xu and Kondo, section 3.2, and of engine/constraints/features.h:
// lines in space that are made to meet, angles in a plane, neighbours that change places.
#pragma once

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "engine/constraints/feature_values.h"
#include "tests/oracle/doo_sabin.h"
#include "tests/oracle/mesh.h"

namespace limn::oracle {

// W_i of a face, in order along the lines as the paper finds them.
Points FeatureCrossings(const Points& face, const std::vector<Real>& edge);
// The same in their right order.
Points InSequence(const Points& face, Points crossings);
// V'_i.
Points FeatureImages(const Points& face, const std::vector<Real>& edge,
                     const std::vector<Real>& vertex);

// The value of an edge, or of a vertex, in a face: looked for in all lists.
Real EdgeValueOf(const FeatureValues& values, int face, int from, int to);
Real VertexValueOf(const FeatureValues& values, int face, int vertex);

// All images, face by face, as if no face were plane.
Points AllFeatureImages(const Mesh& given, const FeatureValues& values);

// Limit points of T^level, level >= 1, of a closed mesh without plane faces.
struct FeatureTiling {
  Tiling tiling;
  Points points;
};
FeatureTiling FeatureLimit(const Mesh& given, const FeatureValues& values, int level);

// The feet of the images of an edge's ends on the edge.
std::pair<Point, Point> FeetOf(const Point& a, const Point& b, const Point& of_a,
                               const Point& of_b);

}  // namespace limn::oracle
