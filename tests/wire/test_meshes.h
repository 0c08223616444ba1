// SPDX-License-Identifier: MIT
// Meshes that the tests of the wire share, and what they compare.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "engine/base/error.h"
#include "engine/mesh/polygon_mesh.h"

namespace limn::wire {

// Expects an error of this reason and, when given, field.
inline void ExpectError(const absl::Status& status, Reason reason, std::string_view field = "") {
  const auto detail = GetErrorDetail(status);
  ASSERT_TRUE(detail.has_value()) << "no error";
  EXPECT_EQ(ReasonName(detail->reason), ReasonName(reason)) << status.ToString();
  if (!field.empty()) {
    EXPECT_EQ(detail->field, field) << status.ToString();
  }
}

inline PolygonMesh MakeMesh(const std::vector<Vec3>& positions,
                            const std::vector<std::vector<Index>>& faces) {
  PolygonMesh mesh;
  mesh.positions.assign(positions.begin(), positions.end());
  for (const auto& face : faces) mesh.AddFace(face);
  return mesh;
}

inline PolygonMesh Tetrahedron() {
  return MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                  {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
}

inline PolygonMesh Cube() {
  return MakeMesh(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

// Two n-gons and n quads.
inline PolygonMesh Prism(Index n) {
  PolygonMesh mesh;
  std::vector<Index> bottom, top;
  for (Index i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 0});
    mesh.positions.push_back({std::cos(angle), std::sin(angle), 1});
    bottom.insert(bottom.begin(), 2 * i);
    top.push_back(2 * i + 1);
  }
  mesh.AddFace(bottom);
  mesh.AddFace(top);
  for (Index i = 0; i < n; ++i) {
    const Index j = (i + 1) % n;
    mesh.AddFace(std::vector<Index>{2 * i, 2 * j, 2 * j + 1, 2 * i + 1});
  }
  return mesh;
}

inline Vec3 TorusPoint(double u, double v) {
  const double r = 3 + std::cos(2 * std::numbers::pi * v);
  return {r * std::cos(2 * std::numbers::pi * u), r * std::sin(2 * std::numbers::pi * u),
          std::sin(2 * std::numbers::pi * v)};
}

// m * n quads, all of valence four.
inline PolygonMesh Torus(Index m, Index n) {
  PolygonMesh mesh;
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < n; ++j) {
      mesh.positions.push_back(TorusPoint(double(i) / m, double(j) / n));
    }
  }
  const auto at = [&](Index i, Index j) { return i % m * n + j % n; };
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < n; ++j) {
      mesh.AddFace(std::vector<Index>{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

// A torus of polygons of 4 to 8 sides in random order, the dual of a grid whose quads are cut
// along random diagonals, with its vertices shuffled.
inline PolygonMesh IrregularTorus(Index m, Index n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<bool> rising(m * n);
  for (Index q = 0; q < m * n; ++q) rising[q] = random() % 2 == 0;
  const auto quad = [&](Index i, Index j) { return (i + m) % m * n + (j + n) % n; };
  // Vertex 2q is the triangle of quad q that holds its lower side, 2q + 1 the other one.
  std::vector<Index> name(2 * m * n);
  for (Index v = 0; v < name.size(); ++v) name[v] = v;
  std::shuffle(name.begin(), name.end(), random);
  PolygonMesh mesh;
  mesh.positions.resize(name.size());
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < n; ++j) {
      const Index q = quad(i, j);
      const double low = rising[q] ? 2.0 / 3 : 1.0 / 3;
      mesh.positions[name[2 * q]] = TorusPoint((i + low) / m, (j + 1.0 / 3) / n);
      mesh.positions[name[2 * q + 1]] = TorusPoint((i + 1 - low) / m, (j + 2.0 / 3) / n);
    }
  }
  std::vector<std::vector<Index>> faces;
  for (Index i = 0; i < m; ++i) {
    for (Index j = 0; j < n; ++j) {
      std::vector<Index> face;
      const auto add = [&](Index q, bool low) { face.push_back(name[2 * q + (low ? 0 : 1)]); };
      // Round grid point (i, j), quad by quad, counter-clockwise. A diagonal that ends at the
      // point gives two triangles, one that does not gives one.
      if (const Index q = quad(i, j); rising[q])
        add(q, true), add(q, false);
      else
        add(q, true);
      if (const Index q = quad(i - 1 + m, j); rising[q])
        add(q, true);
      else
        add(q, false), add(q, true);
      if (const Index q = quad(i - 1 + m, j - 1 + n); rising[q])
        add(q, false), add(q, true);
      else
        add(q, false);
      if (const Index q = quad(i, j - 1 + n); rising[q])
        add(q, false);
      else
        add(q, true), add(q, false);
      faces.push_back(face);
    }
  }
  std::shuffle(faces.begin(), faces.end(), random);
  for (const auto& face : faces) mesh.AddFace(face);
  return mesh;
}

// Faces as sequences that begin with their smallest vertex, sorted: what is left when face order
// and first corners do not count.
inline std::vector<std::vector<Index>> FaceSet(const PolygonMesh& mesh) {
  std::vector<std::vector<Index>> faces;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<Index> face(mesh.face(f).begin(), mesh.face(f).end());
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    faces.push_back(face);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

inline bool SameBits(const Buffer<Vec3>& a, const Buffer<Vec3>& b) {
  return a.size() == b.size() && std::equal(reinterpret_cast<const char*>(a.data()),
                                            reinterpret_cast<const char*>(a.data() + a.size()),
                                            reinterpret_cast<const char*>(b.data()));
}

// Largest distance between two lists of points along an axis.
template <class Points, class Others>
double MaxDeviation(const Points& a, const Others& b) {
  double worst = a.size() == b.size() ? 0 : INFINITY;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    worst = std::max(worst, MaxAbs(a[i] - b[i]));
  }
  return worst;
}

}  // namespace limn::wire
