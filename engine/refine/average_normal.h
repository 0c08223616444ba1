// SPDX-License-Identifier: MIT
// The normal of a polygon that need not be plane. Source: Zheng and Cai 2005, Eq. 10.
#pragma once

#include <algorithm>
#include <cstddef>

#include "engine/base/vec3.h"

namespace limn {

// Twice the vector area of a polygon around the origin [ZC Eq. 10], and the sum of its points'
// squared distances from there.
struct VectorArea {
  Vec3 twice = {0, 0, 0};
  double spread = 0;
};
template <class Point>
VectorArea AreaAroundOrigin(std::size_t m, const Point& p) {
  VectorArea area;
  Vec3 last = p(m - 1);
  for (std::size_t i = 0; i < m; ++i) {
    const Vec3 here = p(i);
    area.twice += Cross(last, here);
    area.spread += Dot(here, here);
    last = here;
  }
  return area;
}

// The average normal of a closed polygon p(0) .. p(m - 1) [ZC Eq. 10], unit length, or (0, 0, 0)
// when the polygon encloses no area but what rounding errors of its points make up.
template <class Point>
Vec3 AverageNormal(std::size_t m, const Vec3& centroid, const Point& p) {
  VectorArea area = AreaAroundOrigin(m, [&](std::size_t i) { return p(i) - centroid; });
  double size = MaxAbs(centroid);
  // Where products under- or overflow, the same at size 1.
  if (!(area.spread > 1e-100 && area.spread < 1e100)) {
    double scale = 0;
    for (std::size_t i = 0; i < m; ++i) scale = std::max(scale, MaxAbs(p(i) - centroid));
    if (!(scale > 0)) return {0, 0, 0};
    area = AreaAroundOrigin(m, [&](std::size_t i) {
      const Vec3 d = p(i) - centroid;
      return Vec3{d.x / scale, d.y / scale, d.z / scale};
    });
    size /= scale;
  }
  // Each product is off by the errors of two offsets; the sum of their lengths is at most
  // sqrt(m spread).
  const double noise = 4 * size * size * static_cast<double>(m) + area.spread;
  constexpr double kNoise = kRoundingNoise * kRoundingNoise;
  if (Dot(area.twice, area.twice) <= kNoise * area.spread * noise) return {0, 0, 0};
  return NormalizedOrZero(area.twice);
}

}  // namespace limn
