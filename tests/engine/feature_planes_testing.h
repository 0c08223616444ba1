// SPDX-License-Identifier: MIT
// What the tests of feature values share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "engine/interpolate.h"
#include "tests/oracle/test_meshes.h"

namespace limn {

// Values of all kinds: defaults, of elements, and of elements in faces.
inline FeatureValues RandomValues(const HalfEdgeMesh& mesh, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> value(0, 1);
  const PolygonWalk walk(mesh);
  FeatureValues values = {.default_edge = value(random), .default_vertex = value(random)};
  for (Index h = 0; h < mesh.half_edge_count(); ++h) {
    const Index v = mesh.vertex()[h];
    if (random() % 2 == 0) {
      values.edges.push_back({v, mesh.vertex()[walk.Next(h)], mesh.face()[h], value(random)});
    }
    if (random() % 3 == 0) values.vertices.push_back({v, mesh.face()[h], value(random)});
    if (mesh.vertex_half_edge()[v] == h && random() % 3 == 0) {
      values.vertices.push_back({v, std::nullopt, value(random)});
    }
  }
  return values;
}

inline FeatureValues Planes(const std::vector<Index>& faces, double edge = 0.4) {
  FeatureValues values = {.default_edge = edge};
  for (const Index f : faces) values.faces.push_back({f, FaceKind::kPlane});
  return values;
}

inline InterpolateResult Made(const PolygonMesh& mesh, const FeatureValues& values,
                              std::uint32_t level) {
  InterpolateOptions options = {.level = level, .keep_patches = true};
  options.constraints.features = values;
  auto result = Interpolate(Context{}, mesh, options);
  EXPECT_TRUE(result.ok()) << result.status();
  return *std::move(result);
}

inline absl::Status Refusal(const PolygonMesh& mesh, const FeatureValues& values) {
  InterpolateOptions options = {.level = 1};
  options.constraints.features = values;
  return Interpolate(Context{}, mesh, options).status();
}

// The vertices of T^level in each face of T^0: the quads of a corner of T^(k - 1) are its four.
inline std::vector<std::set<Index>> VerticesByFace(const PolygonMesh& mesh,
                                                   const Tessellation& surface) {
  std::size_t per_corner = 1;
  for (std::uint32_t k = 1; k < surface.level; ++k) per_corner *= 4;
  std::vector<std::set<Index>> vertices(mesh.face_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    for (std::size_t q = mesh.face_begin[f] * per_corner; q < mesh.face_begin[f + 1] * per_corner;
         ++q) {
      for (std::size_t i = 0; i < 4; ++i) vertices[f].insert(surface.face_vertices[4 * q + i]);
    }
  }
  return vertices;
}

// A cone of `sides` triangles over a polygon, face 0: around the tip there are as many faces.
inline PolygonMesh Cone(int sides) {
  PolygonMesh prism = oracle::Prism(sides);
  PolygonMesh cone;
  for (int i = 0; i < sides; ++i) cone.positions.push_back(prism.positions[prism.face(0)[i]]);
  cone.positions.push_back({0.1, 0.2, 3});
  Buffer<Index> base;
  for (int i = 0; i < sides; ++i) base.push_back(static_cast<Index>(i));
  // Away from the tip.
  double turn = 0;
  for (int i = 0; i < sides; ++i) {
    turn += Cross(cone.positions[i], cone.positions[(i + 1) % sides]).z;
  }
  if (turn > 0) std::reverse(base.begin(), base.end());
  cone.AddFace(base);
  for (int i = 0; i < sides; ++i) {
    cone.AddFace({base[(i + 1) % sides], base[i], static_cast<Index>(sides)});
  }
  return cone;
}

}  // namespace limn
