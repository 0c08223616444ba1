// SPDX-License-Identifier: MIT
#include "engine/scheme/limit_stencil.h"

#include <algorithm>

#include "engine/base/parallel.h"

namespace limn {

bool LimitStencil::uses_edges() const {
  return std::any_of(rows.begin(), rows.end(), [](const LimitRow& r) { return r.edges != 0; });
}

LimitStencil DooSabinModifiedStencil() {
  LimitStencil stencil;
  stencil.rows = {{.vertex = 0.5, .edges = 0, .faces = 0.5}};
  stencil.spectrum_low = 0.5;
  stencil.spectrum_high = 1;
  return stencil;
}

absl::Status FaceCentroids(const Context& context, const HalfEdgeMesh& mesh,
                           absl::Span<const Vec3> points, absl::Span<Vec3> centroids) {
  const Index* const face_begin = mesh.face_begin().data();
  const Index* const vertex = mesh.vertex().data();
  const Vec3* const in = points.data();
  Vec3* const out = centroids.data();
  return ParallelFor(context, mesh.face_count(), [=](std::size_t begin, std::size_t end) {
    Index h = face_begin[begin];
    for (std::size_t f = begin; f < end; ++f) {
      const Index face_end = face_begin[f + 1];
      const double scale = 1.0 / (face_end - h);
      Vec3 sum = in[vertex[h]];
      for (++h; h < face_end; ++h) sum += in[vertex[h]];
      out[f] = scale * sum;
    }
  });
}

}  // namespace limn
