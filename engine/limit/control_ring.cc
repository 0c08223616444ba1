// SPDX-License-Identifier: MIT
#include "engine/limit/control_ring.h"

#include <algorithm>

namespace limn {
namespace {

// What corner `at` of the face p(0) .. p(sides - 1) sees. known: the face's harmonics, or null.
template <class Point>
FaceAtCorner SeenFrom(std::size_t at, std::size_t sides, const Harmonics* known, const Point& p) {
  const std::array<std::size_t, 3> corner = {at == 0 ? sides - 1 : at - 1, at,
                                             at + 1 == sides ? 0 : at + 1};
  FaceAtCorner face;
  face.sides = sides;
  face.harmonics = known != nullptr ? *known : FirstHarmonics(sides, p);
  // Both sums of a face with two sides run over the same dimension.
  const double scale = (sides == 2 ? 1.0 : 2.0) / static_cast<double>(sides);
  for (std::size_t i = 0; i < 3; ++i) {
    const UnitAngle angle = AngleOf(corner[i], sides);
    face.point[i] = p(corner[i]);
    face.first[i] = scale * (angle.cos * face.harmonics.t1 + angle.sin * face.harmonics.t2);
  }
  if (sides == 4) face.opposite = p((at + 2) & 3);
  return face;
}

}  // namespace

ControlRing HalfTurned(const ControlRing& ring) {
  return {.near = ring.far,
          .far = ring.near,
          .below_right = ring.above_left,
          .above_left = ring.below_right};
}

FaceAtCorner RingGatherer::FaceFace(Index h) const {
  const Index f = walk_.Face(h);
  const Index first = walk_.FaceBegin(f);
  const std::size_t sides = walk_.FaceEnd(f) - first;
  return SeenFrom(h - first, sides, sides < LargeFaces::kLarge ? nullptr : large_faces_.OfFace(f),
                  [&](std::size_t i) { return surface_.corners[first + i]; });
}

FaceAtCorner RingGatherer::VertexFace(Index h) {
  const HalfEdgeMesh& mesh = surface_.mesh;
  const Index v = mesh.vertex()[h];
  if (mesh.twin()[mesh.vertex_half_edge()[v]] == kNoIndex) return BoundaryVertexFace(h);
  const Index* const fan = mesh.fan().data() + mesh.fan_begin()[v];
  const std::size_t sides = mesh.valence(v);
  const Harmonics* const known = sides < LargeFaces::kLarge ? nullptr : large_faces_.OfVertex(v);
  const std::size_t at = known != nullptr
                             ? large_faces_.PlaceInFan(h)
                             : static_cast<std::size_t>(std::find(fan, fan + sides, h) - fan);
  return SeenFrom(at, sides, known, [&](std::size_t i) { return surface_.corners[fan[i]]; });
}

FaceAtCorner RingGatherer::BoundaryVertexFace(Index h) {
  const HalfEdgeMesh& mesh = surface_.mesh;
  const BoundaryCurve& curve = surface_.boundary;
  const Index v = mesh.vertex()[h];
  const Index i = curve.Find(mesh.vertex_half_edge()[v]);
  const Harmonics* const known = large_faces_.OfVertex(v);
  if (known == nullptr) {
    GatherBoundaryFace(mesh, curve, surface_.corners.data(), i, &boundary_face_);
    const auto& corner = boundary_face_.corner;
    const auto at = std::find(corner.begin(), corner.end(), h) - corner.begin();
    return SeenFrom(static_cast<std::size_t>(at), boundary_face_.point.size(), nullptr,
                    [&](std::size_t j) { return boundary_face_.point[j]; });
  }
  // Only the first and the last ghost are next to a corner.
  const std::size_t m = mesh.valence(v);
  const Index* const fan = mesh.fan().data() + mesh.fan_begin()[v];
  const auto corner = [&](std::size_t j) { return surface_.corners[fan[j]]; };
  return SeenFrom(large_faces_.PlaceInFan(h), curve.SidesAt(i, m), known, [&](std::size_t j) {
    if (j < m) return corner(j);
    if (j == m) return 2 * (curve.end[curve.previous[i]] - curve.origin) - corner(m - 1);
    return 2 * (curve.start[i] - curve.origin) - corner(0);
  });
}

ControlRing RingGatherer::Gather(Index h) {
  const absl::Span<const Index> twin = surface_.mesh.twin();
  const absl::Span<const Vec3> corners = surface_.corners;
  const BoundaryCurve& curve = surface_.boundary;
  const auto edge_face = [&](Index boundary) {
    return BoundaryEdgeFace(surface_.mesh, curve, corners.data(), curve.Find(boundary));
  };
  const Index prev = walk_.Prev(h);
  ControlRing ring = {.near = VertexFace(h), .far = FaceFace(h)};
  ring.below_right = twin[h] == kNoIndex ? edge_face(h)[3] : corners[twin[h]];
  ring.above_left = twin[prev] == kNoIndex ? edge_face(prev)[2] : corners[walk_.Next(twin[prev])];
  return ring;
}

}  // namespace limn
