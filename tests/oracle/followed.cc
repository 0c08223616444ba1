// SPDX-License-Identifier: MIT
#include "tests/oracle/followed.h"

#include <cmath>
#include <set>
#include <utility>

namespace limn::oracle {
namespace {

std::size_t U(int i) { return static_cast<std::size_t>(i); }

// A face of a mesh, the corner that u and v are counted from, and these.
struct Place {
  std::size_t face;
  std::size_t corner;
  Real u;
  Real v;
};

// The faces that touch a face, which are all that its part of the surface depends on.
CreasedMesh Neighbourhood(const CreasedMesh& mesh, std::size_t* face) {
  const std::set<int> corners(mesh.faces[*face].begin(), mesh.faces[*face].end());
  std::set<std::size_t> kept;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      if (corners.count(v) != 0) kept.insert(f);
    }
  }
  CreasedMesh part = PartOf(mesh, kept, mesh.faces[*face][0]);
  std::size_t number = 0;
  for (const std::size_t f : kept) {
    if (f == *face) break;
    ++number;
  }
  *face = number;
  return part;
}

class Follower {
 public:
  Follower(const CreasedMesh& mesh, Rule rule) : mesh_(mesh), rule_(rule) {}

  FollowedPoint Run(Place place, int steps) {
    place_ = place;
    for (int i = 0; i < steps; ++i) {
      mesh_ = Neighbourhood(mesh_, &place_.face);
      mesh_ = RefineCreased(mesh_, rule_);
      Descend();
      Magnify();
    }
    const Point p = At(0);
    const Point along_u = At(1) - p;
    const Point along_v = At(mesh_.faces[place_.face].size() - 1) - p;
    return {origin_ + scale_ * (p + Apply(place_.u, along_u, place_.v, along_v)),
            Apply(uu_, along_u, uv_, along_v), Apply(vu_, along_u, vv_, along_v)};
  }

 private:
  const Point& At(std::size_t i) const {
    const Face& face = mesh_.faces[place_.face];
    return mesh_.points[U(face[(place_.corner + i) % face.size()])];
  }
  static Point Apply(Real a, const Point& p, Real b, const Point& q) { return a * p + b * q; }

  // To the child at a corner, or the middle triangle.
  void Descend() {
    const Real u = place_.u;
    const Real v = place_.v;
    const std::size_t n = rule_ == Rule::kLoop ? 3 : 4;
    // New parameters, in which the child's size is 1, and their derivatives by the old ones,
    // halved.
    Real next_u = 0;
    Real next_v = 0;
    Real j[2][2];
    std::size_t corner = 0;
    const auto set = [&](std::size_t c, Real a, Real b, Real au, Real av, Real bu, Real bv) {
      corner = c;
      next_u = a;
      next_v = b;
      j[0][0] = au;
      j[0][1] = av;
      j[1][0] = bu;
      j[1][1] = bv;
    };
    if (n == 4) {
      if (u <= 0.5L && v <= 0.5L) {
        set(0, 2 * u, 2 * v, 1, 0, 0, 1);
      } else if (v <= 0.5L) {
        set(1, 2 * v, 2 * (1 - u), 0, 1, -1, 0);
      } else if (u > 0.5L) {
        set(2, 2 * (1 - u), 2 * (1 - v), -1, 0, 0, -1);
      } else {
        set(3, 2 * (1 - v), 2 * u, 0, -1, 1, 0);
      }
    } else {
      const Real w = 1 - u - v;
      if (w >= 0.5L) {
        set(0, 2 * u, 2 * v, 1, 0, 0, 1);
      } else if (u >= 0.5L) {
        set(1, 2 * v, 2 * w, 0, 1, -1, -1);
      } else if (v >= 0.5L) {
        set(2, 2 * w, 2 * u, -1, -1, 1, 0);
      } else {
        // From the point of the first edge on; the ends of its sides are opposite u = 0 and v = 0.
        set(3, 1 - 2 * w, 1 - 2 * u, 1, 1, -1, 0);
      }
    }
    // The middle triangle's corners are the points of the edges, from the first corner's on.
    const std::size_t child = corner == 3 && n == 3 ? 3 : (place_.corner + corner) % n;
    place_ = {4 * place_.face + child, child == 3 && n == 3 ? place_.corner : 0, next_u, next_v};
    Compose(j);
  }

  // d/du = sum over the new parameters of d/dp dp/du.
  void Compose(const Real (&j)[2][2]) {
    // Rows: the given parameters; columns: the present ones.
    const Real old[2][2] = {{uu_, uv_}, {vu_, vv_}};
    Real next[2][2];
    for (int given = 0; given < 2; ++given) {
      for (int p = 0; p < 2; ++p)
        next[given][p] = old[given][0] * j[p][0] + old[given][1] * j[p][1];
    }
    uu_ = next[0][0];
    uv_ = next[0][1];
    vu_ = next[1][0];
    vv_ = next[1][1];
  }

  void Magnify() {
    const Point first = At(0);
    origin_ = origin_ + scale_ * first;
    scale_ /= 2;
    for (Point& p : mesh_.points) p = 2 * (p - first);
  }

  CreasedMesh mesh_;
  const Rule rule_;
  Place place_ = {};
  Point origin_;
  Real scale_ = 1;
  Real uu_ = 1;
  Real uv_ = 0;
  Real vu_ = 0;
  Real vv_ = 1;
};

}  // namespace

FollowedPoint Follow(const CreasedMesh& mesh, Rule rule, const SurfaceParameter& parameter,
                     int steps, Real blend) {
  if (rule == Rule::kLoop) {
    return Follower(mesh, rule)
        .Run({parameter.face, parameter.corner, parameter.u, parameter.v}, steps);
  }
  std::size_t quad = parameter.corner;
  for (std::size_t f = 0; f < parameter.face; ++f) quad += mesh.faces[f].size();
  return Follower(RefineCreased(mesh, rule, blend), rule)
      .Run({quad, 0, parameter.u, parameter.v}, steps);
}

}  // namespace limn::oracle
