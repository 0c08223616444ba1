// SPDX-License-Identifier: MIT
#include "tests/oracle/rotation_map.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace limn::oracle {
namespace {

// Elements of PSL(2, 43): matrices up to their sign.
constexpr int kPrime = 43;
using Element = std::array<int, 4>;

Element Times(const Element& a, const Element& b) {
  const Element m = {(a[0] * b[0] + a[1] * b[2]) % kPrime, (a[0] * b[1] + a[1] * b[3]) % kPrime,
                     (a[2] * b[0] + a[3] * b[2]) % kPrime, (a[2] * b[1] + a[3] * b[3]) % kPrime};
  Element negative = m;
  for (int& x : negative) x = (kPrime - x) % kPrime;
  return std::min(m, negative);
}

// Half-edges are the group's elements: g * kAround is the next one that leaves the same vertex,
// g * kTwin the opposite one. Both and their product have the orders 21, 2 and 21.
constexpr Element kAround = {3, 18, 0, 29};
constexpr Element kTwin = {12, 26, 6, 31};

struct HalfEdges {
  std::vector<std::size_t> around;
  std::vector<std::size_t> twin;
};

HalfEdges Generate() {
  const Element one = {1, 0, 0, 1};
  std::vector<Element> all = {std::min(one, Times(one, one))};
  std::map<Element, std::size_t> number = {{all[0], 0}};
  HalfEdges half_edges;
  const auto find = [&](const Element& g) {
    const auto [at, added] = number.emplace(g, all.size());
    if (added) all.push_back(g);
    return at->second;
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Element g = all[i];
    half_edges.around.push_back(find(Times(g, kAround)));
    half_edges.twin.push_back(find(Times(g, kTwin)));
  }
  return half_edges;
}

// The number of each element's cycle under `next`; *cycles: the elements of each.
template <class Next>
std::vector<Index> Cycles(std::size_t n, const Next& next,
                          std::vector<std::vector<std::size_t>>* cycles) {
  std::vector<Index> cycle(n, kNoIndex);
  for (std::size_t i = 0; i < n; ++i) {
    if (cycle[i] != kNoIndex) continue;
    auto& members = cycles->emplace_back();
    for (std::size_t j = i; cycle[j] == kNoIndex; j = next(j)) {
      cycle[j] = static_cast<Index>(cycles->size() - 1);
      members.push_back(j);
    }
  }
  return cycle;
}

// 4 L - 3, whose spectrum is within [-1, 1].
std::vector<double> Shifted(const std::vector<std::vector<Index>>& faces,
                            const std::vector<double>& x) {
  std::vector<double> sum(x.size(), 0);
  std::vector<double> valence(x.size(), 0);
  for (const auto& face : faces) {
    double mean = 0;
    for (const Index v : face) mean += x[v] / static_cast<double>(face.size());
    for (const Index v : face) {
      sum[v] += mean;
      valence[v] += 1;
    }
  }
  for (std::size_t v = 0; v < x.size(); ++v) sum[v] = 2 * x[v] + 2 * sum[v] / valence[v] - 3 * x[v];
  return sum;
}

// Row v of T_k(4 L - 3), which is a column too where all valences are the same.
std::vector<double> ChebyshevRow(const std::vector<std::vector<Index>>& faces, std::size_t vertices,
                                 std::size_t v, int k) {
  std::vector<double> before(vertices, 0);
  before[v] = 1;
  std::vector<double> now = Shifted(faces, before);
  for (int i = 1; i < k; ++i) {
    std::vector<double> next = Shifted(faces, now);
    for (std::size_t u = 0; u < vertices; ++u) next[u] = 2 * next[u] - before[u];
    before = std::move(now);
    now = std::move(next);
  }
  return now;
}

}  // namespace

PolygonMesh RotationMap() {
  const HalfEdges half_edges = Generate();
  const std::size_t n = half_edges.around.size();
  std::vector<std::vector<std::size_t>> vertex_cycles;
  const std::vector<Index> vertex = Cycles(
      n, [&](std::size_t i) { return half_edges.around[i]; }, &vertex_cycles);
  std::vector<std::vector<std::size_t>> face_cycles;
  Cycles(
      n, [&](std::size_t i) { return half_edges.around[half_edges.twin[i]]; }, &face_cycles);
  std::vector<std::vector<Index>> faces;
  for (const auto& cycle : face_cycles) {
    auto& face = faces.emplace_back();
    for (const std::size_t i : cycle) face.push_back(vertex[i]);
  }
  PolygonMesh mesh;
  mesh.positions.resize(vertex_cycles.size());
  const auto side = [](double x) { return x < 0 ? -1.0 : 1.0; };
  const std::vector<double> x = ChebyshevRow(faces, mesh.positions.size(), 100, 17);
  const std::vector<double> y = ChebyshevRow(faces, mesh.positions.size(), 700, 17);
  const std::vector<double> z = ChebyshevRow(faces, mesh.positions.size(), 1500, 17);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    mesh.positions[v] = {side(x[v]), side(y[v]), side(z[v])};
  }
  mesh.face_begin = {0};
  for (const auto& face : faces) {
    mesh.corner_vertex.insert(mesh.corner_vertex.end(), face.begin(), face.end());
    mesh.face_begin.push_back(static_cast<Index>(mesh.corner_vertex.size()));
  }
  return mesh;
}

}  // namespace limn::oracle
