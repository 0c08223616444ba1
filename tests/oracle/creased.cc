// SPDX-License-Identifier: MIT
#include "tests/oracle/creased.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <tuple>

namespace limn::oracle {
namespace {

std::size_t U(int i) { return static_cast<std::size_t>(i); }

Point Mean(const Points& points) { return Centroid(points); }

Real Decayed(Real sharpness) {
  if (sharpness >= kForever) return sharpness;
  return std::max<Real>(0, sharpness - 1);
}

// A vertex before a step, and the rules for it.
class VertexRules {
 public:
  VertexRules(const CreasedMesh& mesh, const Incidence& incidence, Rule rule, int v)
      : mesh_(mesh), incidence_(incidence), rule_(rule), v_(v) {
    for (const int edge : incidence.edges_of_vertex[U(v)]) {
      sharpness_.push_back(SharpnessOf(mesh, incidence, edge));
    }
  }

  // The rule of the sharpness now, blended with that of the sharpness after the step.
  Point Refined(const Points& face_points, Real blend) const {
    const Real own = mesh_.vertex_sharpness[U(v_)];
    std::vector<Real> after;
    for (const Real s : sharpness_) after.push_back(Decayed(s));
    const Point now = Apply(own, sharpness_, face_points, blend);
    if (KindOf(own, sharpness_) == KindOf(Decayed(own), after) || !IsSharp(own, sharpness_)) {
      return now;
    }
    const Real weight = Transition(own, after);
    return weight * now + (1 - weight) * Apply(Decayed(own), after, face_points, blend);
  }

 private:
  enum class Kind { kSmooth, kDart, kCrease, kCorner };

  static Kind KindOf(Real own, const std::vector<Real>& edges) {
    if (own > 0) return Kind::kCorner;
    const auto sharp = std::count_if(edges.begin(), edges.end(), [](Real s) { return s > 0; });
    if (sharp == 0) return Kind::kSmooth;
    if (sharp == 1) return Kind::kDart;
    return sharp == 2 ? Kind::kCrease : Kind::kCorner;
  }
  static bool IsSharp(Real own, const std::vector<Real>& edges) {
    const Kind kind = KindOf(own, edges);
    return kind == Kind::kCrease || kind == Kind::kCorner;
  }

  // Mean of the sharpnesses that vanish in this step, at most 1.
  Real Transition(Real own, const std::vector<Real>& after) const {
    Real sum = 0;
    int count = 0;
    if (own > 0 && Decayed(own) == 0) {
      sum += own;
      ++count;
    }
    for (std::size_t i = 0; i < after.size(); ++i) {
      if (sharpness_[i] > 0 && after[i] == 0) {
        sum += sharpness_[i];
        ++count;
      }
    }
    return count == 0 ? 0 : std::min<Real>(1, sum / count);
  }

  Point Apply(Real own, const std::vector<Real>& edges, const Points& face_points,
              Real blend) const {
    const Point& p = mesh_.points[U(v_)];
    switch (KindOf(own, edges)) {
      case Kind::kCorner:
        return p;
      case Kind::kCrease: {
        Point sum = 6 * p;
        for (std::size_t i = 0; i < edges.size(); ++i) {
          if (edges[i] > 0) sum = sum + Neighbour(i);
        }
        return (1 / Real{8}) * sum;
      }
      default:
        return blend * p + (1 - blend) * Smooth(face_points);
    }
  }

  Point Smooth(const Points& face_points) const {
    const Point& p = mesh_.points[U(v_)];
    const Real n = static_cast<Real>(sharpness_.size());
    Points around;
    for (std::size_t i = 0; i < sharpness_.size(); ++i) around.push_back(Neighbour(i));
    if (rule_ == Rule::kLoop) {
      const Real c = 3 / Real{8} + std::cos(2 * std::numbers::pi_v<Real> / n) / 4;
      const Real pull = 5 / Real{8} - c * c;
      return (1 - pull) * p + pull * Mean(around);
    }
    Points faces;
    for (const int f : incidence_.faces_of_vertex[U(v_)]) faces.push_back(face_points[U(f)]);
    const Point q = Mean(faces);
    const Point r = 0.5L * (p + Mean(around));
    return (1 / n) * (q + 2 * r + (n - 3) * p);
  }

  const Point& Neighbour(std::size_t i) const {
    return mesh_.points[U(OtherEnd(mesh_, incidence_.edges_of_vertex[U(v_)][i], v_))];
  }

  const CreasedMesh& mesh_;
  const Incidence& incidence_;
  const Rule rule_;
  const int v_;
  // Of the edges of the vertex, in the order of the incidence.
  std::vector<Real> sharpness_;
};

// The vertex of a triangle that is not on the edge.
const Point& Across(const CreasedMesh& mesh, int face, int edge) {
  const auto [a, b] = mesh.edges[U(edge)];
  for (const int v : mesh.faces[U(face)]) {
    if (v != a && v != b) return mesh.points[U(v)];
  }
  return mesh.points[U(a)];
}

Point EdgePoint(const CreasedMesh& mesh, const Incidence& incidence, Rule rule, int edge,
                const Points& face_points, Real blend) {
  const auto [a, b] = mesh.edges[U(edge)];
  const Point middle = 0.5L * (mesh.points[U(a)] + mesh.points[U(b)]);
  const Real sharpness = std::min<Real>(1, SharpnessOf(mesh, incidence, edge));
  if (sharpness >= 1) return middle;
  const std::vector<int>& faces = incidence.faces_of_edge[U(edge)];
  Point smooth;
  if (rule == Rule::kLoop) {
    smooth =
        0.75L * middle + 0.125L * (Across(mesh, faces[0], edge) + Across(mesh, faces[1], edge));
  } else {
    smooth = 0.5L * middle + 0.25L * (face_points[U(faces[0])] + face_points[U(faces[1])]);
    smooth = blend * middle + (1 - blend) * smooth;
  }
  return sharpness * middle + (1 - sharpness) * smooth;
}

// Gives the new edges their numbers, in the order of first occurrence. A new edge is known by what
// it comes from: an old edge and one of its ends, or an old face and a corner of it.
class EdgeBuilder {
 public:
  explicit EdgeBuilder(CreasedMesh* mesh) : mesh_(mesh) {}

  using Key = std::tuple<int, int, int>;
  int Number(const Key& key, int from, int to, Real sharpness) {
    const auto [at, fresh] = numbers_.emplace(key, static_cast<int>(mesh_->edges.size()));
    if (fresh) {
      mesh_->edges.emplace_back(from, to);
      mesh_->edge_sharpness.push_back(sharpness);
    }
    return at->second;
  }

 private:
  CreasedMesh* mesh_;
  std::map<Key, int> numbers_;
};

void SplitFaces(const CreasedMesh& mesh, Rule rule, CreasedMesh* refined) {
  EdgeBuilder builder(refined);
  const int first_edge = static_cast<int>(mesh.points.size());
  const int first_face = first_edge + static_cast<int>(mesh.edges.size());
  const auto half = [&](int edge, int v, int from, int to) {
    return builder.Number({0, edge, v}, from, to, Decayed(mesh.edge_sharpness[U(edge)]));
  };
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Face& face = mesh.faces[f];
    const std::size_t m = face.size();
    const int number = static_cast<int>(f);
    Face middle;
    std::vector<int> middle_sides;
    for (std::size_t i = 0; i < m; ++i) {
      const std::size_t before = (i + m - 1) % m;
      const int leaving = first_edge + mesh.sides[f][i];
      const int entering = first_edge + mesh.sides[f][before];
      const int a = half(mesh.sides[f][i], face[i], face[i], leaving);
      Face corner = {face[i], leaving};
      std::vector<int> sides = {a};
      if (rule == Rule::kLoop) {
        sides.push_back(builder.Number({1, number, static_cast<int>(i)}, leaving, entering, 0));
      } else {
        // The edge from an edge point to the face point belongs to the corner that it leaves.
        corner.push_back(first_face + number);
        sides.push_back(
            builder.Number({1, number, static_cast<int>(i)}, leaving, first_face + number, 0));
        sides.push_back(builder.Number({1, number, static_cast<int>(before)}, first_face + number,
                                       entering, 0));
      }
      corner.push_back(entering);
      sides.push_back(half(mesh.sides[f][before], face[i], entering, face[i]));
      refined->faces.push_back(corner);
      refined->sides.push_back(sides);
      refined->hole.push_back(mesh.hole[f]);
      middle.push_back(leaving);
      // From this edge point to the next one: the side that cuts off the next corner.
      middle_sides.push_back(static_cast<int>((i + 1) % m));
    }
    if (rule != Rule::kLoop) continue;
    for (std::size_t i = 0; i < m; ++i) {
      middle_sides[i] =
          builder.Number({1, number, middle_sides[i]}, middle[i], middle[(i + 1) % m], 0);
    }
    refined->faces.push_back(middle);
    refined->sides.push_back(middle_sides);
    refined->hole.push_back(mesh.hole[f]);
  }
}

}  // namespace

int OtherEnd(const CreasedMesh& mesh, int edge, int v) {
  const auto [a, b] = mesh.edges[U(edge)];
  return a == v ? b : a;
}

Incidence IncidenceOf(const CreasedMesh& mesh) {
  Incidence incidence;
  incidence.edges_of_vertex.resize(mesh.points.size());
  incidence.faces_of_vertex.resize(mesh.points.size());
  incidence.faces_of_edge.resize(mesh.edges.size());
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    incidence.edges_of_vertex[U(mesh.edges[e].first)].push_back(static_cast<int>(e));
    incidence.edges_of_vertex[U(mesh.edges[e].second)].push_back(static_cast<int>(e));
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      incidence.faces_of_vertex[U(v)].push_back(static_cast<int>(f));
    }
    for (const int e : mesh.sides[f]) incidence.faces_of_edge[U(e)].push_back(static_cast<int>(f));
  }
  return incidence;
}

Real SharpnessOf(const CreasedMesh& mesh, const Incidence& incidence, int edge) {
  if (incidence.faces_of_edge[U(edge)].size() == 1) return kForever;
  return mesh.edge_sharpness[U(edge)];
}

CreasedMesh StartCreased(const Mesh& mesh) {
  CreasedMesh start;
  start.points = mesh.points;
  start.faces = mesh.faces;
  const EdgeNumbers numbers = NumberEdges(mesh.faces);
  start.edges.resize(numbers.size());
  for (const auto& [ends, number] : numbers) start.edges[U(number)] = ends;
  for (const Face& face : mesh.faces) {
    std::vector<int> sides;
    for (std::size_t i = 0; i < face.size(); ++i) {
      sides.push_back(numbers.at(EdgeKey(face[i], face[(i + 1) % face.size()])));
    }
    start.sides.push_back(sides);
  }
  start.edge_sharpness.assign(start.edges.size(), 0);
  start.vertex_sharpness.assign(start.points.size(), 0);
  start.hole.assign(start.faces.size(), false);
  return start;
}

CreasedMesh RefineCreased(const CreasedMesh& mesh, Rule rule, Real blend) {
  const Incidence incidence = IncidenceOf(mesh);
  Points face_points;
  for (const Face& face : mesh.faces) {
    Points corners;
    for (const int v : face) corners.push_back(mesh.points[U(v)]);
    face_points.push_back(Mean(corners));
  }
  CreasedMesh refined;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const VertexRules rules(mesh, incidence, rule, static_cast<int>(v));
    refined.points.push_back(rules.Refined(face_points, blend));
    refined.vertex_sharpness.push_back(Decayed(mesh.vertex_sharpness[v]));
  }
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    refined.points.push_back(
        EdgePoint(mesh, incidence, rule, static_cast<int>(e), face_points, blend));
  }
  if (rule == Rule::kCatmullClark) {
    refined.points.insert(refined.points.end(), face_points.begin(), face_points.end());
  }
  refined.vertex_sharpness.resize(refined.points.size(), 0);
  SplitFaces(mesh, rule, &refined);
  return refined;
}

CreasedMesh PartOf(const CreasedMesh& mesh, const std::set<std::size_t>& kept, int vertex) {
  CreasedMesh part;
  std::map<int, int> vertices;
  std::map<int, int> edges;
  const auto vertex_number = [&](int v) {
    const auto [at, fresh] = vertices.emplace(v, static_cast<int>(part.points.size()));
    if (fresh) {
      part.points.push_back(mesh.points[U(v)]);
      part.vertex_sharpness.push_back(mesh.vertex_sharpness[U(v)]);
    }
    return at->second;
  };
  vertex_number(vertex);
  for (const std::size_t f : kept) {
    Face face;
    std::vector<int> sides;
    for (const int v : mesh.faces[f]) face.push_back(vertex_number(v));
    for (const int e : mesh.sides[f]) {
      const auto [at, fresh] = edges.emplace(e, static_cast<int>(part.edges.size()));
      if (fresh) {
        const auto [a, b] = mesh.edges[U(e)];
        part.edges.emplace_back(vertex_number(a), vertex_number(b));
        part.edge_sharpness.push_back(mesh.edge_sharpness[U(e)]);
      }
      sides.push_back(at->second);
    }
    part.faces.push_back(face);
    part.sides.push_back(sides);
    part.hole.push_back(mesh.hole[f]);
  }
  return part;
}

}  // namespace limn::oracle
