// SPDX-License-Identifier: MIT
#include "tests/oracle/creases.h"

#include <cstddef>
#include <map>
#include <random>
#include <set>

namespace limn::oracle {
namespace {

std::size_t U(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void AddCrease(const PolygonMesh& mesh, std::uint64_t seed, float sharpness, Creases* creases) {
  std::map<Index, std::set<Index>> neighbours;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Index next = face[(i + 1) % face.size()];
      neighbours[face[i]].insert(next);
      neighbours[next].insert(face[i]);
    }
  }
  std::mt19937_64 random(seed);
  Index at = static_cast<Index>(random() % mesh.vertex_count());
  std::set<Index> visited = {at};
  std::vector<Index> path = {at};
  const std::size_t longest = 2 + random() % 5;
  while (path.size() < longest) {
    std::vector<Index> ways;
    for (const Index v : neighbours[at]) {
      if (visited.count(v) == 0) ways.push_back(v);
    }
    if (ways.empty()) break;
    at = ways[random() % ways.size()];
    visited.insert(at);
    path.push_back(at);
  }
  creases->indices.insert(creases->indices.end(), path.begin(), path.end());
  creases->lengths.push_back(static_cast<Index>(path.size()));
  creases->sharpnesses.push_back(sharpness);
}

Creases RandomCreases(const PolygonMesh& mesh, std::uint64_t seed) {
  Creases creases;
  std::uint64_t next = 100 * seed;
  for (const float sharpness : {0.3F, 1.0F, 2.7F, 10.0F, 0.3F, 2.7F}) {
    AddCrease(mesh, ++next, sharpness, &creases);
  }
  std::mt19937_64 random(++next);
  for (const float sharpness : {0.4F, 1.5F, 10.0F}) {
    creases.corners.push_back(static_cast<Index>(random() % mesh.vertex_count()));
    creases.corner_sharpnesses.push_back(sharpness);
  }
  creases.holes.push_back(static_cast<Index>(random() % mesh.face_count()));
  return creases;
}

CreasedMesh WithCreases(const Mesh& mesh, const Creases& creases) {
  CreasedMesh creased = StartCreased(mesh);
  std::map<std::pair<int, int>, std::size_t> edges;
  for (std::size_t e = 0; e < creased.edges.size(); ++e) {
    edges[EdgeKey(creased.edges[e].first, creased.edges[e].second)] = e;
  }
  std::size_t at = 0;
  for (std::size_t c = 0; c < creases.lengths.size(); ++c) {
    for (std::size_t i = 1; i < creases.lengths[c]; ++i) {
      const auto key = EdgeKey(static_cast<int>(creases.indices[at + i - 1]),
                               static_cast<int>(creases.indices[at + i]));
      creased.edge_sharpness[edges.at(key)] = creases.sharpnesses[c];
    }
    at += creases.lengths[c];
  }
  for (std::size_t i = 0; i < creases.corners.size(); ++i) {
    creased.vertex_sharpness[creases.corners[i]] = creases.corner_sharpnesses[i];
  }
  for (const Index f : creases.holes) creased.hole[f] = true;
  if (creases.boundary != BoundaryRule::kEdgeAndCorner) return creased;
  const Incidence incidence = IncidenceOf(creased);
  for (std::size_t v = 0; v < creased.points.size(); ++v) {
    bool boundary = false;
    for (const int e : incidence.edges_of_vertex[v]) {
      boundary = boundary || incidence.faces_of_edge[U(e)].size() == 1;
    }
    if (boundary && incidence.faces_of_vertex[v].size() == 1) {
      creased.vertex_sharpness[v] = kForever;
    }
  }
  return creased;
}

}  // namespace limn::oracle
