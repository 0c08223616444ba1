// SPDX-License-Identifier: MIT
#include "engine/limit/regular_ring.h"

#include "engine/scheme/sharpness.h"

namespace limn {
namespace {

// A sector of a ring: `faces` faces from edge `begin` on.
struct SectorView {
  const VertexRing& ring;
  std::size_t begin;
  std::size_t faces;

  const Vec3& Edge(std::size_t i) const { return ring.edge[(begin + i) % ring.edge.size()]; }
  const Vec3& Face(std::size_t i) const { return ring.face[(begin + i) % ring.face.size()]; }
};

// Counter-clockwise from the sector's first edge.
RegularRing MirroredCrease(RingKind kind, const SectorView& s) {
  if (kind == RingKind::kTriangles) {
    return {
        {s.Edge(0), s.Edge(1), s.Edge(2), s.Edge(3), s.Edge(3) - s.Edge(2), s.Edge(0) - s.Edge(1)},
        {}};
  }
  return {{s.Edge(0), s.Edge(1), s.Edge(2), -s.Edge(1)},
          {s.Face(0), s.Face(1), 2 * s.Edge(2) - s.Face(1), 2 * s.Edge(0) - s.Face(0)}};
}

RegularRing MirroredCorner(RingKind kind, const SectorView& s) {
  const Vec3& a = s.Edge(0);
  const Vec3& b = s.Edge(1);
  if (kind == RingKind::kTriangles) return {{a, b, b - a, -a, -b, a - b}, {}};
  const Vec3& f = s.Face(0);
  return {{a, b, -a, -b}, {f, 2 * b - f, f - 2 * (a + b), 2 * a - f}};
}

// The ring of n edges, from edge `first` on.
template <std::size_t kSize>
void Rotate(const std::array<Vec3, kSize>& from, std::size_t n, std::size_t first,
            std::array<Vec3, kSize>* to) {
  for (std::size_t i = 0; i < n; ++i) (*to)[i] = from[(first + i) % n];
}

bool WearsOff(float sharpness) { return sharpness > 0 && sharpness < kSharpForever; }

}  // namespace

bool FindRegularRing(RingKind kind, const VertexRing& ring, std::size_t face,
                     RegularRing* regular) {
  const bool quads = kind == RingKind::kQuads;
  const std::size_t regular_size = quads ? 4 : 6;
  const std::size_t n = ring.edge.size();
  std::size_t sharp = 0;
  if (WearsOff(ring.corner)) return false;
  for (const float sharpness : ring.sharp) {
    if (WearsOff(sharpness)) return false;
    if (sharpness > 0) ++sharp;
  }
  const VertexRule rule = RuleOf(ring.corner, sharp);
  if (rule == VertexRule::kSmooth) {
    if (n != regular_size) return false;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t from = face + i < n ? face + i : face + i - n;
      regular->edge[i] = ring.edge[from];
      if (quads) regular->diagonal[i] = ring.face[from];
    }
    return true;
  }
  if (rule == VertexRule::kDart || sharp == 0) return false;
  // Open rings begin with a sharp edge.
  std::size_t i = 0;
  while (ring.sharp[(face + n - i) % n] == 0) ++i;
  SectorView sector = {ring, (face + n - i) % n, i + 1};
  while (ring.sharp[(sector.begin + sector.faces) % n] == 0) ++sector.faces;
  const bool corner = rule == VertexRule::kCorner;
  if (sector.faces != (corner ? 1 : regular_size / 2)) return false;
  const RegularRing whole = corner ? MirroredCorner(kind, sector) : MirroredCrease(kind, sector);
  Rotate(whole.edge, regular_size, i, &regular->edge);
  if (quads) Rotate(whole.diagonal, 4, i, &regular->diagonal);
  return true;
}

}  // namespace limn
