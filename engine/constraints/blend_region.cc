// SPDX-License-Identifier: MIT
#include "engine/constraints/blend_region.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace limn {
namespace {

constexpr std::size_t kSmallest = 3;
constexpr std::size_t kLargest = 6;

// Vertices by ring around a place.
struct Rings {
  // In ring order.
  std::vector<Index> vertices;
  absl::flat_hash_map<Index, std::size_t> ring;
};

constexpr std::size_t kAllRings = std::numeric_limits<std::size_t>::max();

// The rings 0 to `last`, of the vertices that may_enter. ends(v, ring): asked in ring order,
// whether what comes after is not needed; the rings before that of v are whole then.
template <class MayEnter, class Ends>
Rings FindRings(const HalfEdgeMesh& mesh, absl::Span<const Index> start, std::size_t last,
                const MayEnter& may_enter, const Ends& ends) {
  Rings rings;
  for (const Index v : start) {
    if (may_enter(v) && rings.ring.try_emplace(v, 0).second) rings.vertices.push_back(v);
  }
  for (std::size_t i = 0; i < rings.vertices.size(); ++i) {
    const Index v = rings.vertices[i];
    const std::size_t ring = rings.ring[v];
    if (ends(v, ring)) break;
    if (ring == last) continue;
    VisitRing(mesh, v, [&](Index w) {
      if (may_enter(w) && rings.ring.try_emplace(w, ring + 1).second) rings.vertices.push_back(w);
    });
  }
  return rings;
}

bool Always(Index /*v*/) { return true; }
bool Never(Index /*v*/, std::size_t /*ring*/) { return false; }

// 1 at t = 1 and 0 at t = 0, level at both.
double Smooth(double t) { return t * t * (3 - 2 * t); }

// inside: rings from the place; outside: rings to the first vertex that does not move.
double Weight(std::size_t inside, std::size_t outside, std::size_t plateau) {
  if (inside <= plateau) return 1;
  const auto way = static_cast<double>(outside);
  return Smooth(way / (way + static_cast<double>(inside - plateau)));
}

void FindTouched(const BlendPlaces& places, std::size_t i, BlendRegion* region) {
  absl::flat_hash_set<Index> near;
  absl::flat_hash_set<std::size_t> touched;
  const auto note = [&](Index v) {
    if (touched.size() > kMostTouched || !near.insert(v).second) return;
    places.VisitAt(v, [&](std::size_t j) {
      if (j != i) touched.insert(j);
      return touched.size() <= kMostTouched;
    });
  };
  for (const Index v : region->vertices) {
    note(v);
    VisitRing(places.mesh(), v, note);
  }
  region->touched.assign(touched.begin(), touched.end());
  std::sort(region->touched.begin(), region->touched.end());
}

}  // namespace

void BlendPlaces::Add(BlendPlace place) {
  for (const Index v : place) by_vertex_[v].push_back(places_.size());
  if (place.size() == 1) taken_.insert(place[0]);
  places_.push_back(std::move(place));
}

std::vector<Index> Support(const HalfEdgeMesh& mesh, const BlendPlace& place) {
  return FindRings(mesh, place, 1, Always, Never).vertices;
}

BlendRegion ChooseRegion(const BlendPlaces& places, std::size_t i) {
  std::size_t nearest = kLargest + 1;
  const auto ends = [&](Index v, std::size_t ring) {
    places.VisitAt(v, [&](std::size_t j) {
      if (j != i) nearest = std::min(nearest, ring);
      return j == i;
    });
    return ring >= kSmallest && nearest <= ring;
  };
  const Rings rings = FindRings(places.mesh(), places.At(i), kLargest, Always, ends);
  const std::size_t end = nearest <= kSmallest ? kSmallest : nearest - 1;
  const std::size_t plateau = end / 2;
  BlendRegion region;
  for (const Index v : rings.vertices) {
    const std::size_t ring = rings.ring.at(v);
    if (ring >= end) break;
    region.vertices.push_back(v);
    region.weights.push_back(Weight(ring, end - ring, plateau));
  }
  if (nearest <= kSmallest) FindTouched(places, i, &region);
  return region;
}

BlendRegion GivenRegion(const BlendPlaces& places, std::size_t i, absl::Span<const Index> faces) {
  const HalfEdgeMesh& mesh = places.mesh();
  const absl::flat_hash_set<Index> in_region(faces.begin(), faces.end());
  // Corners of faces whose vertices' faces are all in the region, so that a vertex moves when all
  // vertices of its faces are such.
  absl::flat_hash_map<Index, bool> surrounded;
  const auto is_surrounded = [&](Index v) {
    const auto [at, fresh] = surrounded.try_emplace(v, true);
    if (!fresh) return at->second;
    bool all = true;
    WithWalk(mesh, [&](const auto& walk) {
      VisitFan(walk, mesh.twin(), mesh.vertex_half_edge()[v],
               [&](Index h) { all = all && in_region.contains(walk.Face(h)); });
    });
    surrounded[v] = all;
    return all;
  };
  absl::flat_hash_map<Index, bool> moving;
  const auto moves = [&](Index v) {
    const auto [at, fresh] = moving.try_emplace(v, true);
    if (!fresh) return at->second;
    bool all = is_surrounded(v);
    VisitRing(mesh, v, [&](Index w) { all = all && is_surrounded(w); });
    moving[v] = all;
    return all;
  };
  const Rings rings = FindRings(mesh, places.At(i), kAllRings, moves, Never);
  const std::vector<Index> support = Support(mesh, places.At(i));
  if (!std::all_of(support.begin(), support.end(), moves)) return {};

  // From those next to vertices that stay, inwards.
  std::vector<Index> rim;
  std::size_t nearest = rings.vertices.size();
  for (const Index v : rings.vertices) {
    bool next_to_fixed = false;
    VisitRing(mesh, v, [&](Index w) { next_to_fixed = next_to_fixed || !moves(w); });
    if (!next_to_fixed) continue;
    rim.push_back(v);
    nearest = std::min(nearest, rings.ring.at(v) + 1);
  }
  const Rings inwards = FindRings(
      mesh, rim, kAllRings, [&](Index v) { return rings.ring.contains(v); }, Never);
  const std::size_t plateau = std::max<std::size_t>(1, nearest / 2);
  BlendRegion region;
  for (const Index v : rings.vertices) {
    const auto way = inwards.ring.find(v);
    region.vertices.push_back(v);
    // Whole components may be given: nothing fades.
    region.weights.push_back(
        way == inwards.ring.end() ? 1 : Weight(rings.ring.at(v), way->second + 1, plateau));
  }
  FindTouched(places, i, &region);
  return region;
}

}  // namespace limn
