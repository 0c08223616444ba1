// SPDX-License-Identifier: MIT
#include "tests/oracle/deep_limit.h"

#include <algorithm>
#include <map>
#include <set>

namespace limn::oracle {
namespace {

std::size_t U(int i) { return static_cast<std::size_t>(i); }

// The faces within two rings of a vertex, which becomes vertex 0. Where they end is no matter: a
// refinement spoils one ring of four.
CreasedMesh Around(const CreasedMesh& mesh, int vertex) {
  std::set<int> near = {vertex};
  std::set<std::size_t> kept;
  for (int ring = 0; ring < 2; ++ring) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      for (const int v : mesh.faces[f]) {
        if (near.count(v) != 0) kept.insert(f);
      }
    }
    for (const std::size_t f : kept) near.insert(mesh.faces[f].begin(), mesh.faces[f].end());
  }
  return PartOf(mesh, kept, vertex);
}

// Moves vertex 0 to the origin and scales its farthest neighbour to 1.
void Magnify(CreasedMesh* mesh) {
  const Point origin = mesh->points[0];
  Real size = 0;
  for (Point& p : mesh->points) p = p - origin;
  for (const auto& [a, b] : mesh->edges) {
    if (a == 0 || b == 0) size = std::max(size, Norm(mesh->points[U(a + b)]));
  }
  if (size == 0) return;
  for (Point& p : mesh->points) p = (1 / size) * p;
}

// The edges of vertex 0, counter-clockwise.
std::vector<int> FanOf(const CreasedMesh& mesh, bool* closed, std::vector<int>* across) {
  // From each edge to the next one across a face.
  std::map<int, int> next;
  std::map<int, int> across_of;
  std::set<int> entered;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const std::size_t m = mesh.faces[f].size();
    for (std::size_t i = 0; i < m; ++i) {
      if (mesh.faces[f][i] != 0) continue;
      next[mesh.sides[f][i]] = mesh.sides[f][(i + m - 1) % m];
      across_of[mesh.sides[f][i]] = mesh.faces[f][(i + m / 2) % m];
      entered.insert(mesh.sides[f][(i + m - 1) % m]);
    }
  }
  *closed = true;
  int start = next.begin()->first;
  for (const auto& [edge, after] : next) {
    if (mesh.edge_sharpness[U(edge)] > 0) start = edge;
  }
  for (const auto& [edge, after] : next) {
    if (entered.count(edge) == 0) {
      start = edge;
      *closed = false;
    }
  }
  std::vector<int> fan = {start};
  for (auto at = next.find(start); at != next.end(); at = next.find(fan.back())) {
    if (at->second == start) break;
    fan.push_back(at->second);
  }
  for (const int edge : fan) {
    if (across_of.count(edge) != 0) across->push_back(across_of[edge]);
  }
  return fan;
}

Point NormalOf(const DeepLimit& limit, bool corner) {
  const std::size_t n = limit.ring.size();
  const std::size_t faces = limit.closed ? n : n - 1;
  const auto cross = [&](std::size_t i) {
    return Cross(limit.ring[i % n], limit.ring[(i + 1) % n]);
  };
  const auto sharp = std::count(limit.sharp.begin(), limit.sharp.end(), true);
  Point sum;
  if (sharp == 0 || (sharp == 1 && !corner)) {
    for (std::size_t i = 0; i < n; ++i) {
      sum = sum + Cross(limit.ring[i], limit.across[i]) +
            Cross(limit.across[i], limit.ring[(i + 1) % n]);
    }
    return Unit(sum);
  }
  for (std::size_t begin = 0; begin < faces;) {
    std::size_t end = begin + 1;
    while (end < faces && !limit.sharp[end % n]) ++end;
    sum = sum + Unit(Unit(cross(begin)) + Unit(cross(end - 1)));
    begin = end;
  }
  return Unit(sum);
}

}  // namespace

DeepLimit RefineDeeply(const CreasedMesh& mesh, Rule rule, int vertex, int steps) {
  CreasedMesh part = Around(mesh, vertex);
  DeepLimit limit;
  Point origin;
  Real scale = 1;
  for (int i = 0; i < steps; ++i) {
    part = Around(RefineCreased(part, rule), 0);
    limit.point = origin + scale * part.points[0];
    const Point before = part.points[0];
    Real size = 0;
    for (const auto& [a, b] : part.edges) {
      if (a == 0 || b == 0) size = std::max(size, Norm(part.points[U(a + b)] - before));
    }
    Magnify(&part);
    origin = limit.point;
    if (size > 0) scale *= size;
  }
  std::vector<int> across;
  for (const int edge : FanOf(part, &limit.closed, &across)) {
    limit.ring.push_back(part.points[U(OtherEnd(part, edge, 0))]);
    limit.sharp.push_back(part.edge_sharpness[U(edge)] > 0);
  }
  for (const int v : across) limit.across.push_back(part.points[U(v)]);
  if (!limit.closed) limit.sharp.front() = limit.sharp.back() = true;
  limit.normal = NormalOf(limit, part.vertex_sharpness[0] > 0);
  return limit;
}

}  // namespace limn::oracle
