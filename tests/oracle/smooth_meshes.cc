// SPDX-License-Identifier: MIT
#include "tests/oracle/smooth_meshes.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>

namespace limn::oracle {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

PolygonMesh RoundTorus(int around, int across, double ring, double tube) {
  PolygonMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double s = 2 * kPi * i / around;
      const double t = 2 * kPi * j / across;
      const double radius = ring + tube * std::cos(t);
      mesh.positions.push_back({radius * std::cos(s), radius * std::sin(s), tube * std::sin(t)});
    }
  }
  const auto at = [&](int i, int j) {
    return static_cast<Index>(i % around * across + j % across);
  };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      mesh.AddFace({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

PolygonMesh CubeSphere(int n) {
  PolygonMesh mesh;
  std::map<std::array<int, 3>, Index> numbers;
  const auto number = [&](const std::array<int, 3>& place) {
    const auto [at, fresh] = numbers.emplace(place, static_cast<Index>(mesh.vertex_count()));
    if (fresh) {
      const auto on_cube = [&](int i) { return std::tan(kPi / 4 * (2.0 * i / n - 1)); };
      const Vec3 p = {on_cube(place[0]), on_cube(place[1]), on_cube(place[2])};
      mesh.positions.push_back((1 / Norm(p)) * p);
    }
    return at->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const auto corner = [&](int side, int di, int dj) {
          std::array<int, 3> place{};
          place[axis] = side * n;
          place[(axis + 1) % 3] = i + di;
          place[(axis + 2) % 3] = j + dj;
          return number(place);
        };
        mesh.AddFace({corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)});
        mesh.AddFace({corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)});
      }
    }
  }
  return mesh;
}

}  // namespace limn::oracle
