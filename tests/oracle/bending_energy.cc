// SPDX-License-Identifier: MIT
#include "tests/oracle/bending_energy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace limn::oracle {
namespace {

using Net = std::array<std::array<Point, 3>, 3>;

struct Weighted {
  Real at;
  Real weight;
};

std::array<Weighted, 4> Gauss() {
  const Real inner = std::sqrt(3.0L / 7 - 2.0L / 7 * std::sqrt(1.2L)) / 2;
  const Real outer = std::sqrt(3.0L / 7 + 2.0L / 7 * std::sqrt(1.2L)) / 2;
  const Real heavy = (18 + std::sqrt(30.0L)) / 72;
  const Real light = (18 - std::sqrt(30.0L)) / 72;
  return {Weighted{0.5L - outer, light}, Weighted{0.5L - inner, heavy},
          Weighted{0.5L + inner, heavy}, Weighted{0.5L + outer, light}};
}

// The sum of weights a of columns and b of rows.
Point Combine(const Net& net, const std::array<Real, 3>& a, const std::array<Real, 3>& b) {
  Point sum;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) sum = sum + (a[i] * b[j]) * net[j][i];
  }
  return sum;
}

Real PatchEnergy(const Net& net) {
  const auto value = [](Real t) {
    return std::array<Real, 3>{(1 - t) * (1 - t) / 2, 0.5L + t * (1 - t), t * t / 2};
  };
  const auto first = [](Real t) { return std::array<Real, 3>{t - 1, 1 - 2 * t, t}; };
  const std::array<Real, 3> second = {1, -2, 1};
  Real sum = 0;
  for (const Weighted& v : Gauss()) {
    for (const Weighted& u : Gauss()) {
      const Point du = Combine(net, first(u.at), value(v.at));
      const Point dv = Combine(net, value(u.at), first(v.at));
      const Point n = Cross(du, dv);
      const Real area = Norm(n);
      if (area <= 1e-14L * Norm(du) * Norm(dv)) continue;
      const Point unit = (1 / area) * n;
      const Real l = Dot(unit, Combine(net, second, value(v.at)));
      const Real m = Dot(unit, Combine(net, first(u.at), first(v.at)));
      const Real o = Dot(unit, Combine(net, value(u.at), second));
      const Real h = (Dot(du, du) * o - 2 * Dot(du, dv) * m + Dot(dv, dv) * l) / (2 * area * area);
      sum += u.weight * v.weight * h * h * area;
    }
  }
  return sum;
}

struct CornerOfFace {
  std::size_t face;
  std::size_t i;
};

int At(const DooSabinMesh& mesh, const CornerOfFace& corner, std::size_t step) {
  const Face& face = mesh.faces[corner.face];
  return face[(corner.i + step) % face.size()];
}

// The quads around a vertex, each at the corner of the vertex, counter-clockwise: in the next one
// the vertex is followed by what it is preceded by here. Empty if some face is no quad.
std::vector<CornerOfFace> QuadsAround(const DooSabinMesh& mesh,
                                      const std::vector<CornerOfFace>& corners) {
  for (const CornerOfFace& corner : corners) {
    if (mesh.faces[corner.face].size() != 4) return {};
  }
  std::vector<CornerOfFace> around = {corners[0]};
  while (around.size() < corners.size()) {
    const CornerOfFace last = around.back();
    const int wanted = mesh.sides[last.face][(last.i + 3) % 4];
    const auto next = std::find_if(corners.begin(), corners.end(), [&](const CornerOfFace& c) {
      return c.face != last.face && mesh.sides[c.face][c.i] == wanted;
    });
    if (next == corners.end()) return {};
    around.push_back(*next);
  }
  return around;
}

}  // namespace

Real BendingEnergy(const Mesh& given, absl::Span<const Vec3> corners, int level) {
  Tiling tiling = TilingOf(given);
  DooSabinMesh mesh = RefineFirst(Start(given), tiling);
  mesh.points = FromVec3(corners);
  for (int k = 1; k < level; ++k) {
    tiling = Split(tiling);
    mesh = Refine(mesh, tiling);
  }
  std::vector<std::vector<CornerOfFace>> corners_of(mesh.points.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < mesh.faces[f].size(); ++i) {
      corners_of[static_cast<std::size_t>(mesh.faces[f][i])].push_back({f, i});
    }
  }
  Real sum = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const std::vector<CornerOfFace> quads = QuadsAround(mesh, corners_of[v]);
    if (quads.size() != 4) continue;
    const auto point = [&](std::size_t quad, std::size_t step) {
      return mesh.points[static_cast<std::size_t>(At(mesh, quads[quad], step))];
    };
    sum += PatchEnergy({{{point(2, 2), point(3, 1), point(3, 2)},
                         {point(2, 1), mesh.points[v], point(0, 1)},
                         {point(1, 2), point(1, 1), point(0, 2)}}});
  }
  return sum;
}

}  // namespace limn::oracle
