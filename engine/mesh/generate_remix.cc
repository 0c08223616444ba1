// SPDX-License-Identifier: MIT
// Edge flips and removals on a small half-edge structure.
#include "engine/mesh/generate_remix.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace limn::generate {

Remix::Remix(const PolygonMesh& mesh, absl::Span<const Vec3> normals, const RemixLimits& limits)
    : mesh_(mesh), normals_(normals), limits_(limits) {
  const std::size_t corners = mesh.corner_count();
  vertex_ = mesh.corner_vertex;
  next_.resize(corners);
  prev_.resize(corners);
  face_.resize(corners);
  arity_.resize(mesh.face_count());
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const Index begin = mesh.face_begin[f];
    const Index end = mesh.face_begin[f + 1];
    arity_[f] = end - begin;
    for (Index c = begin; c < end; ++c) {
      next_[c] = c + 1 == end ? begin : c + 1;
      prev_[next_[c]] = c;
      face_[c] = static_cast<Index>(f);
    }
  }
  PairTwins();
}

// Half-edges are put into a bucket per smaller end; a pair is two of a bucket with equal larger
// end.
void Remix::PairTwins() {
  const std::size_t corners = vertex_.size();
  twin_.resize(corners, kNoIndex);
  valence_.resize(mesh_.vertex_count(), 0);
  Buffer<Index> first(mesh_.vertex_count() + 1, 0);
  const auto smaller = [&](Index h) { return std::min(vertex_[h], vertex_[next_[h]]); };
  for (Index h = 0; h < corners; ++h) ++first[smaller(h) + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  Buffer<Index> filled(first.begin(), first.end() - 1);
  Buffer<Index> bucket(corners);
  for (Index h = 0; h < corners; ++h) {
    const Index v = smaller(h);
    // The bucket's half-edges that still wait for their twin are in [first, filled).
    Index slot = first[v];
    while (slot < filled[v] && (vertex_[bucket[slot]] != vertex_[next_[h]] ||
                                vertex_[next_[bucket[slot]]] != vertex_[h])) {
      ++slot;
    }
    if (slot < filled[v]) {
      twin_[h] = bucket[slot];
      twin_[bucket[slot]] = h;
      bucket[slot] = bucket[--filled[v]];
    } else {
      bucket[filled[v]++] = h;
    }
  }
  for (Index h = 0; h < corners; ++h) {
    if (twin_[h] != kNoIndex && twin_[h] < h) continue;
    ++valence_[vertex_[h]];
    ++valence_[vertex_[next_[h]]];
  }
}

// Whether the turn from a to c is to the left at b.
bool Remix::Convex(Index a, Index b, Index c) const {
  const Vec3 in = mesh_.positions[b] - mesh_.positions[a];
  const Vec3 out = mesh_.positions[c] - mesh_.positions[b];
  return Dot(Cross(in, out), normals_[b]) > limits_.min_turn * Norm(in) * Norm(out);
}

// Whether the vertex of `corner` has an edge to `other`.
bool Remix::Adjacent(Index corner, Index other) const {
  Index h = corner;
  do {
    if (vertex_[next_[h]] == other || vertex_[prev_[h]] == other) return true;
    h = twin_[prev_[h]];
  } while (h != corner && h != kNoIndex);
  if (h == corner) return false;
  for (h = twin_[corner]; h != kNoIndex; h = twin_[h]) {  // the fan's other half
    h = next_[h];
    if (vertex_[next_[h]] == other) return true;
  }
  return false;
}

//      c                c
//    /   \            / | \           .
//   a --> b    =>    a  |  b
//    \   /            \ v /
//      d                d
bool Remix::Flip(Index h) {
  const Index t = twin_[h];
  if (t == kNoIndex || arity_[face_[h]] != 3 || arity_[face_[t]] != 3) return false;
  const Index a = vertex_[h];
  const Index b = vertex_[t];
  const Index bc = next_[h];
  const Index ca = prev_[h];
  const Index ad = next_[t];
  const Index db = prev_[t];
  const Index c = vertex_[ca];
  const Index d = vertex_[db];
  if (valence_[a] <= limits_.min_valence || valence_[b] <= limits_.min_valence) return false;
  if (valence_[c] >= limits_.max_valence || valence_[d] >= limits_.max_valence) return false;
  if (!Convex(c, a, d) || !Convex(d, b, c) || Adjacent(ca, d)) return false;
  const auto triangle = [&](Index x, Index y, Index z, Index f) {
    next_[x] = prev_[z] = y;
    next_[y] = prev_[x] = z;
    next_[z] = prev_[y] = x;
    face_[x] = face_[y] = face_[z] = f;
  };
  vertex_[h] = c;
  vertex_[t] = d;
  const Index left = face_[h];
  const Index right = face_[t];
  triangle(h, db, bc, right);
  triangle(t, ca, ad, left);
  --valence_[a];
  --valence_[b];
  ++valence_[c];
  ++valence_[d];
  return true;
}

// Whether the two faces of h have no vertex in common but its ends.
bool Remix::ShareOnlyEdge(Index h) const {
  const Index t = twin_[h];
  for (Index i = next_[next_[h]]; i != h; i = next_[i]) {
    for (Index j = next_[next_[t]]; j != t; j = next_[j]) {
      if (vertex_[i] == vertex_[j]) return false;
    }
  }
  return true;
}

bool Remix::Merge(Index h) {
  const Index t = twin_[h];
  if (t == kNoIndex || vertex_[h] == kNoIndex) return false;
  const Index kept = face_[h];
  const Index gone = face_[t];
  const Index a = vertex_[h];
  const Index b = vertex_[t];
  if (kept == gone || arity_[kept] + arity_[gone] - 2 > limits_.max_arity) return false;
  if (valence_[a] <= limits_.min_valence || valence_[b] <= limits_.min_valence) return false;
  if (!Convex(vertex_[prev_[h]], a, vertex_[next_[next_[t]]])) return false;
  if (!Convex(vertex_[prev_[t]], b, vertex_[next_[next_[h]]])) return false;
  if (!ShareOnlyEdge(h)) return false;
  for (Index i = next_[t]; i != t; i = next_[i]) face_[i] = kept;
  next_[prev_[h]] = next_[t];
  prev_[next_[t]] = prev_[h];
  next_[prev_[t]] = next_[h];
  prev_[next_[h]] = prev_[t];
  arity_[kept] += arity_[gone] - 2;
  arity_[gone] = 0;
  vertex_[h] = vertex_[t] = kNoIndex;
  --valence_[a];
  --valence_[b];
  return true;
}

Buffer<Index> Remix::EdgesInRandomOrder(Random* random) const {
  Buffer<Index> edges;
  edges.reserve(vertex_.size() / 2);
  for (Index h = 0; h < vertex_.size(); ++h) {
    if (twin_[h] != kNoIndex && twin_[h] > h && vertex_[h] != kNoIndex) edges.push_back(h);
  }
  random->Shuffle(&edges);
  return edges;
}

void Remix::FlipSome(double share_of_edges, Random* random) {
  const Buffer<Index> edges = EdgesInRandomOrder(random);
  const auto count = static_cast<std::size_t>(share_of_edges * static_cast<double>(edges.size()));
  for (std::size_t i = 0; i < count; ++i) Flip(edges[i]);
}

bool Remix::OnBoundary(Index corner) const {
  Index h = corner;
  do {
    if (twin_[h] == kNoIndex) return true;
    h = twin_[prev_[h]];
  } while (h != corner && h != kNoIndex);
  return h == kNoIndex;
}

// One vertex after the other, so that what was checked stays true.
void Remix::Smooth(const Place& place, PolygonMesh* mesh) const {
  constexpr int kRounds = 3;
  const Buffer<Index> corners = FirstCorners();
  for (int round = 0; round < kRounds; ++round) {
    for (const Index first : corners) {
      if (OnBoundary(first)) continue;
      const Index v = vertex_[first];
      Vec3 sum = {0, 0, 0};
      for (Index h = first; true;) {
        sum += mesh->positions[vertex_[next_[h]]];
        h = twin_[prev_[h]];
        if (h == first) break;
      }
      const Vec3 old = mesh->positions[v];
      mesh->positions[v] = place(0.5 * old + 0.5 / valence_[v] * sum);
      if (Folds(first)) mesh->positions[v] = old;
    }
  }
}

// Whether a triangle around the corner's vertex looks the wrong way or has next to no area.
bool Remix::Folds(Index corner) const {
  const Index v = vertex_[corner];
  Index h = corner;
  do {
    const Vec3 a = mesh_.positions[vertex_[next_[h]]] - mesh_.positions[v];
    const Vec3 b = mesh_.positions[vertex_[prev_[h]]] - mesh_.positions[v];
    if (Dot(Cross(a, b), normals_[v]) < limits_.min_turn * Norm(a) * Norm(b)) return true;
    h = twin_[prev_[h]];
  } while (h != corner);
  return false;
}

std::size_t Remix::MergeSome(std::size_t wanted, Random* random) {
  const Buffer<Index> edges = EdgesInRandomOrder(random);
  // Some vertices keep all their edges, or large valences would die out.
  std::vector<char> kept(valence_.size());
  for (char& keep : kept) keep = random->Below(10) == 0 ? 1 : 0;
  std::size_t merged = 0;
  for (const Index h : edges) {
    const Index most = std::max(valence_[vertex_[h]], valence_[vertex_[twin_[h]]]);
    if (most > limits_.max_valence) merged += Merge(h) ? 1 : 0;
  }
  for (std::size_t i = 0; i < edges.size() && merged < wanted; ++i) {
    const Index h = edges[i];
    if (vertex_[h] == kNoIndex || kept[vertex_[h]] != 0 || kept[vertex_[twin_[h]]] != 0) continue;
    merged += Merge(h) ? 1 : 0;
  }
  return merged;
}

void Remix::TakeFaces(PolygonMesh* mesh) const {
  Buffer<Index> face_begin(1, 0);
  Buffer<Index> corner_vertex;
  face_begin.reserve(arity_.size() + 1);
  corner_vertex.reserve(vertex_.size());
  std::vector<bool> done(arity_.size(), false);
  for (Index first = 0; first < vertex_.size(); ++first) {
    if (vertex_[first] == kNoIndex || done[face_[first]]) continue;
    done[face_[first]] = true;
    Index h = first;
    do {
      corner_vertex.push_back(vertex_[h]);
      h = next_[h];
    } while (h != first);
    face_begin.push_back(static_cast<Index>(corner_vertex.size()));
  }
  mesh->face_begin = std::move(face_begin);
  mesh->corner_vertex = std::move(corner_vertex);
}

Buffer<Index> Remix::FirstCorners() const {
  Buffer<Index> corner(mesh_.vertex_count(), kNoIndex);
  for (Index h = 0; h < vertex_.size(); ++h) {
    if (vertex_[h] != kNoIndex && corner[vertex_[h]] == kNoIndex) corner[vertex_[h]] = h;
  }
  return corner;
}

}  // namespace limn::generate
