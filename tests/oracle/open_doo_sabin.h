// SPDX-License-Identifier: MIT
// Doo-Sabin interpolation of open meshes with constraints, from the words of the headers: a dense
// system with the curves' equations for boundary vertices, and a first refined mesh in which ghosts
// are vertices like any other, so that the closed rules refine it.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "tests/oracle/doo_sabin.h"

namespace limn::oracle {

struct Wishes {
  // One per vertex; empty: all are interpolated.
  std::vector<bool> interpolated;
  std::map<int, Point> normals;
  std::map<int, Real> handles;
  // Eq. 1 instead of Eq. 4 in the first step.
  bool standard_rule = false;
  // Images that come from elsewhere, corner by corner; empty: by the rule.
  Points images;
  // Curve points from elsewhere: the one near v on the boundary edge of v and w, under (v, w). The
  // others are (3 V + W) / 4.
  std::map<std::pair<int, int>, Point> curve;

  bool meets(int v) const {
    return interpolated.empty() || interpolated[static_cast<std::size_t>(v)];
  }
};

// The corners around a vertex, counter-clockwise, as (face, place in the face); on a boundary from
// the corner whose leaving edge is on it.
struct Corner {
  int face;
  int place;
};
struct Fan {
  std::vector<Corner> corners;
  bool boundary = false;
  // Neighbours along the boundary: where the leaving edge goes, where the entering edge comes from.
  int next = -1;
  int previous = -1;
};
std::vector<Fan> FansOf(const Mesh& mesh);

// The control points.
Points SolveOpen(const Mesh& given, const Wishes& wishes);

// M^1 with ghosts, perturbed.
DooSabinMesh OpenFirstRefined(const Mesh& given, const Points& control, const Wishes& wishes);

// As InterpolateDooSabin.
Interpolated InterpolateOpen(const Mesh& given, const Wishes& wishes, int level);

}  // namespace limn::oracle
