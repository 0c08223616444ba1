// SPDX-License-Identifier: MIT
// The images of one face's points in a Doo-Sabin refinement step. Sources: Doo and Sabin 1978;
// Zheng and Cai 2005, Eqs. 1 (the scheme's own rule) and 4 (the modified first step).
#pragma once

#include <cstddef>

#include "engine/base/vec3.h"
#include "engine/refine/harmonics.h"

namespace limn {

// Rule of the first refinement, M^0 -> M^1, which the interpolation equations are set up with.
enum class FirstRule {
  // (V + centroid) / 2 [ZC Eq. 4].
  kModified,
  // The scheme's own, Nasri's method for Doo-Sabin [ZC Eq. 1].
  kStandard,
  // Vertices stay, edges get their midpoints: Catmull-Clark only, see RefineCatmullClark.
  kBilinear,
  // By feature values, of the given mesh itself (engine/constraints/features.h). Said of a result,
  // not asked for.
  kFeatures,
};

// [ZC Eq. 1] for a quad: the image of `own`.
inline Vec3 QuadImage(const Vec3& own, const Vec3& side_a, const Vec3& side_b,
                      const Vec3& opposite) {
  return 0.0625 * (9.0 * own + 3.0 * (side_a + side_b) + opposite);
}

// [ZC Eq. 1] for an m-gon, by its eigenvalues: mean + h/2 + rest/4, where own = mean + h + rest and
// h = (2/m)(cos t1 + sin t2). get(i) is point i, put(i, image) takes its image.
template <class Get, class Put>
void PolygonImages(std::size_t m, const Get& get, const Put& put) {
  const Harmonics f = FirstHarmonics(m, get);
  const double scale = 0.5 / static_cast<double>(m);
  for (std::size_t i = 0; i < m; ++i) {
    const UnitAngle angle = AngleOf(i, m);
    put(i, 0.25 * get(i) + 0.75 * f.mean + scale * (angle.cos * f.t1 + angle.sin * f.t2));
  }
}

// The same for any m, quads the short way. put may not write what get reads.
template <class Get, class Put>
void FaceImages(std::size_t m, const Get& get, const Put& put) {
  if (m != 4) return PolygonImages(m, get, put);
  const Vec3 p[4] = {get(0), get(1), get(2), get(3)};
  for (std::size_t i = 0; i < 4; ++i) {
    put(i, QuadImage(p[i], p[(i + 1) & 3], p[(i + 3) & 3], p[(i + 2) & 3]));
  }
}

// The weight of a point in its own image: (m + 5) / (4 m), and that of the point d corners away.
inline double OwnWeight(std::size_t m) {
  return (static_cast<double>(m) + 5) / (4 * static_cast<double>(m));
}
inline double OtherWeight(std::size_t d, std::size_t m) {
  return (3 + 2 * AngleOf(d, m).cos) / (4 * static_cast<double>(m));
}

}  // namespace limn
