// SPDX-License-Identifier: MIT
#include "engine/limit/ring_limit.h"

#include <algorithm>

#include "engine/refine/harmonics.h"
#include "engine/refine/loop_refine.h"
#include "engine/scheme/sharpness.h"

namespace limn {
namespace {

// Two curves that go on straight through a vertex, up to this angle, span no plane in any
// refinement that is in use, though they may in the limit: what is across shrinks against them like
// 1 / 2^k in one quad, like (3/4)^k in two triangles.
constexpr double kStraight = 1e-3;
constexpr double kNearlyStraight = 0.05;

// Whether vectors from a point to both sides form a straight line, within an angle.
bool FormLine(const Vec3& u, const Vec3& v, double angle) {
  const Vec3 to_u = NormalizedOrZero(u);
  const Vec3 to_v = NormalizedOrZero(v);
  return Dot(to_u, to_v) < 0 && Norm(Cross(to_u, to_v)) <= angle;
}

// The direction of a sum of unit normals. Opposite ones leave no more than rounding.
Vec3 MeanNormal(const Vec3& sum) {
  constexpr double kNoDirection = 1e-6;
  return Norm(sum) > kNoDirection ? NormalizedOrZero(sum) : Vec3{0, 0, 0};
}

Vec3 Sum(const std::vector<Vec3>& vectors) {
  Vec3 sum = {0, 0, 0};
  for (const Vec3& v : vectors) sum += v;
  return sum;
}

// Length of v, by its largest coordinate, times the sine of its angle to u. Safe for any length.
double SineTimesLength(const Vec3& u, const Vec3& v) {
  return Norm(Cross(NormalizedOrZero(u), NormalizedOrZero(v))) * MaxAbs(v);
}

// The part of a ring from one sharp edge to the next.
class Sector {
 public:
  // first: edge that it starts with; faces: 1 or more. size: magnitude of the coordinates.
  Sector(RingKind kind, const VertexRing& ring, std::size_t first, std::size_t faces)
      : kind_(kind), ring_(ring), first_(first), faces_(faces) {
    size_ = MaxAbs(ring.point) + std::max(MaxAbs(Edge(0)), MaxAbs(Edge(faces)));
  }

  // u is the derivative of the curve, v points across the faces.
  Tangents OnCrease() const {
    const Vec3 u = 0.5 * (Edge(0) - Edge(faces_));
    if (faces_ > 1) return {u, Apply(CreaseMask(kind_, faces_))};
    const Vec3 bend = Edge(0) + Edge(1);
    if (kind_ == RingKind::kTriangles) return {u, bend};
    // Eigenvalue 1/4 belongs to the bend of the curve, which drags the quad's other vertex along.
    const Vec3 across = Face(0);
    return {u, SineTimesLength(u, bend) <= kStraight * SineTimesLength(u, across) ? across : bend};
  }
  Vec3 CreaseNormal() const {
    const Tangents t = OnCrease();
    return UnitCross(t.u, t.v, size_);
  }

  // Tangent along edge i of the sector.
  Vec3 AlongCrease(std::size_t i) const {
    const Tangents t = OnCrease();
    if (i == 0) return t.u;
    if (i == faces_) return -t.u;
    const UnitAngle angle = AngleOf(i, 2 * faces_);
    return angle.cos * t.u + angle.sin * t.v;
  }
  Vec3 AlongCorner(std::size_t i) const {
    if (i == 0 || i == faces_) return Edge(i);
    // What is across shrinks faster than the pull of both curves.
    if (faces_ == 2 && kind_ == RingKind::kTriangles) return Edge(0) + Edge(2);
    return AngleOf(i, 2 * faces_).sin * Apply(CornerMask(kind_, faces_));
  }

  // The derivatives of the two curves that end here.
  Tangents OnCorner() const { return {Edge(0), Edge(faces_)}; }
  Vec3 CornerNormal() const {
    const auto [u, v] = OnCorner();
    const bool quads = kind_ == RingKind::kQuads;
    if (faces_ == 1) {
      return quads && FormLine(u, v, kStraight) ? UnitCross(u - v, Face(0), size_)
                                                : UnitCross(u, v, size_);
    }
    if (!quads && faces_ == 2 && !FormLine(u, v, kNearlyStraight)) return UnitCross(u, v, size_);
    const Vec3 across = Apply(CornerMask(kind_, faces_));
    return MeanNormal(UnitCross(u, across, size_) + UnitCross(across, v, size_));
  }

 private:
  const Vec3& Edge(std::size_t i) const { return ring_.edge[(first_ + i) % ring_.edge.size()]; }
  const Vec3& Face(std::size_t i) const { return ring_.face[(first_ + i) % ring_.face.size()]; }

  Vec3 Apply(const SectorMask& mask) const {
    Vec3 edges = {0, 0, 0};
    for (std::size_t i = 1; i < faces_; ++i) edges += AngleOf(i, 2 * faces_).sin * Edge(i);
    Vec3 across = mask.edge * edges + mask.ends * (Edge(0) + Edge(faces_));
    if (kind_ == RingKind::kTriangles) return across;
    Vec3 faces = {0, 0, 0};
    for (std::size_t i = 0; i < faces_; ++i) {
      faces += AngleOf(2 * i + 1, 4 * faces_).sin * Face(i);
    }
    return across + mask.face * faces;
  }

  const RingKind kind_;
  const VertexRing& ring_;
  const std::size_t first_;
  const std::size_t faces_;
  double size_;
};

// A ring and what its sharp edges make of it.
class RingLimit {
 public:
  RingLimit(RingKind kind, const VertexRing& ring)
      : kind_(kind), ring_(ring), n_(ring.edge.size()) {
    for (std::size_t i = 0; i < n_; ++i) {
      if (ring.sharp[i] == 0) continue;
      if (sharp_edges_ == 0) first_ = i;
      last_ = i;
      ++sharp_edges_;
    }
    rule_ = RuleOf(ring.corner, sharp_edges_);
  }

  Vec3 Point() const {
    switch (rule_) {
      case VertexRule::kSmooth: {
        const PointMask mask = SmoothPointMask(kind_, n_);
        return ring_.point + (mask.edge * Sum(ring_.edge) + mask.face * Sum(ring_.face));
      }
      case VertexRule::kDart:
        return ring_.point + ApplyDart(DartPointMask(kind_, n_));
      case VertexRule::kCrease:
        return ring_.point + (1 / 6.0) * (ring_.edge[first_] + ring_.edge[last_]);
      default:
        return ring_.point;
    }
  }

  VertexFrame Frame() const {
    VertexFrame frame = {.point = Point()};
    if (has_sectors()) {
      AddSectors(&frame);
      return frame;
    }
    frame.tangents = SmoothTangents();
    if (rule_ == VertexRule::kDart) frame.tangents.u = ApplyDart(DartTangentMask(kind_, n_));
    const double size = MaxAbs(ring_.point) + MaxAbs(ring_.edge[0]);
    frame.normal = UnitCross(frame.tangents.u, frame.tangents.v, size);
    return frame;
  }

  CornerFrame Corner(std::size_t face) const {
    if (has_sectors()) return SectorCorner(face);
    const VertexFrame frame = Frame();
    const auto along = [&](std::size_t i) {
      const UnitAngle angle = AngleOf(i % n_, n_);
      return angle.cos * frame.tangents.u + angle.sin * frame.tangents.v;
    };
    const std::size_t i = (face + n_ - first_) % n_;
    return {frame.point, along(i), along(i + 1), frame.normal};
  }

 private:
  bool has_sectors() const { return sharp_edges_ >= (rule_ == VertexRule::kCorner ? 1U : 2U); }

  CornerFrame SectorCorner(std::size_t face) const {
    // Open rings begin with a sharp edge.
    std::size_t i = 0;
    while (ring_.sharp[(face + n_ - i) % n_] == 0) ++i;
    const std::size_t begin = (face + n_ - i) % n_;
    std::size_t faces = i + 1;
    while (ring_.sharp[(begin + faces) % n_] == 0) ++faces;
    const Sector sector(kind_, ring_, begin, faces);
    if (rule_ == VertexRule::kCrease) {
      return {Point(), sector.AlongCrease(i), sector.AlongCrease(i + 1), sector.CreaseNormal()};
    }
    return {Point(), sector.AlongCorner(i), sector.AlongCorner(i + 1), sector.CornerNormal()};
  }

  // From the sharp edge on, if there is one.
  Tangents SmoothTangents() const {
    const PointMask mask = SmoothTangentMask(kind_, n_);
    Tangents t;
    for (std::size_t i = 0; i < n_; ++i) {
      const UnitAngle angle = AngleOf(i, n_);
      const Vec3 edge = mask.edge * ring_.edge[(first_ + i) % n_];
      t.u += angle.cos * edge;
      t.v += angle.sin * edge;
    }
    for (std::size_t i = 0; i < ring_.face.size(); ++i) {
      const UnitAngle angle = AngleOf(2 * i + 1, 2 * n_);
      const Vec3 face = mask.face * ring_.face[(first_ + i) % n_];
      t.u += angle.cos * face;
      t.v += angle.sin * face;
    }
    return t;
  }

  Vec3 ApplyDart(const DartMask& mask) const {
    Vec3 sum = {0, 0, 0};
    for (std::size_t i = 0; i < n_; ++i) sum += mask.edge[i] * ring_.edge[(first_ + i) % n_];
    for (std::size_t i = 0; i < mask.face.size(); ++i) {
      sum += mask.face[i] * ring_.face[(first_ + i) % n_];
    }
    return sum;
  }

  // Tangents of the first sector, and the mean of all normals.
  void AddSectors(VertexFrame* frame) const {
    const bool crease = rule_ == VertexRule::kCrease;
    Vec3 normals = {0, 0, 0};
    std::size_t sectors = 0;
    for (std::size_t begin = first_; begin < (ring_.closed ? n_ + first_ : last_);) {
      std::size_t end = begin + 1;
      while (ring_.sharp[end % n_] == 0) ++end;
      const Sector sector(kind_, ring_, begin, end - begin);
      if (sectors == 0) frame->tangents = crease ? sector.OnCrease() : sector.OnCorner();
      normals += crease ? sector.CreaseNormal() : sector.CornerNormal();
      ++sectors;
      begin = end;
    }
    frame->normal = MeanNormal(normals);
  }

  const RingKind kind_;
  const VertexRing& ring_;
  const std::size_t n_;
  std::size_t sharp_edges_ = 0;
  std::size_t first_ = 0;
  std::size_t last_ = 0;
  VertexRule rule_ = VertexRule::kSmooth;
};

bool WearsOff(float sharpness) { return sharpness > 0 && sharpness < kSharpForever; }

// Where the vertex goes, as a difference; faces: the centroids of the ring's faces.
Vec3 RefinedVertex(RingKind kind, const VertexRing& ring) {
  const std::size_t n = ring.edge.size();
  VertexBlend blend({0, 0, 0}, ring.corner);
  for (std::size_t i = 0; i < n; ++i) blend.Add(ring.sharp[i], ring.edge[i]);
  if (!blend.needs_smooth()) return blend.Point({0, 0, 0});
  const double m = static_cast<double>(n);
  if (kind == RingKind::kTriangles) {
    return blend.Point((LoopNeighbourWeight(n) / m) * Sum(ring.edge));
  }
  return blend.Point((1 / (m * m)) * (Sum(ring.edge) + Sum(ring.face)));
}

}  // namespace

void RefineRing(RingKind kind, bool centroids, VertexRing* ring) {
  const std::size_t n = ring->edge.size();
  const bool quads = kind == RingKind::kQuads;
  if (quads && !centroids) {
    for (std::size_t i = 0; i < ring->face.size(); ++i) {
      ring->face[i] = 0.25 * (ring->edge[i] + ring->edge[(i + 1) % n] + ring->face[i]);
    }
  }
  const Vec3 moved = RefinedVertex(kind, *ring);
  const std::vector<Vec3> ends = ring->edge;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 middle = 0.5 * ends[i];
    if (ring->sharp[i] >= 1) {
      ring->edge[i] = middle - moved;
      continue;
    }
    // Not on the boundary: there is a face to both sides.
    const std::size_t before = (i + n - 1) % n;
    const Vec3 smooth = quads ? 0.25 * (ends[i] + ring->face[i] + ring->face[before])
                              : 0.375 * ends[i] + 0.125 * (ends[before] + ends[(i + 1) % n]);
    ring->edge[i] = BlendEdge(ring->sharp[i], middle, smooth) - moved;
  }
  for (Vec3& face : ring->face) face -= moved;
  ring->point += moved;
  for (float& sharpness : ring->sharp) sharpness = Worn(sharpness);
  ring->corner = Worn(ring->corner);
}

void SettleRing(RingKind kind, VertexRing* ring) {
  while (WearsOff(ring->corner) || std::any_of(ring->sharp.begin(), ring->sharp.end(), WearsOff)) {
    RefineRing(kind, false, ring);
  }
}

Vec3 RingPoint(RingKind kind, const VertexRing& ring) { return RingLimit(kind, ring).Point(); }

VertexFrame RingFrame(RingKind kind, const VertexRing& ring) {
  return RingLimit(kind, ring).Frame();
}

CornerFrame RingCorner(RingKind kind, const VertexRing& ring, std::size_t face) {
  return RingLimit(kind, ring).Corner(face);
}

}  // namespace limn
