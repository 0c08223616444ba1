// SPDX-License-Identifier: MIT
#include "tests/oracle/doo_sabin.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

namespace limn::oracle {
namespace {

constexpr Real kPi = std::numbers::pi_v<Real>;

// A side of a face: the edge from its i-th vertex to the next.
struct Side {
  std::size_t face;
  std::size_t i;
};

// The sides of each edge: two, or one on a boundary.
std::vector<std::vector<Side>> SidesOfEdges(const DooSabinMesh& mesh) {
  std::vector<std::vector<Side>> edges;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t i = 0; i < mesh.faces[f].size(); ++i) {
      const auto e = static_cast<std::size_t>(mesh.sides[f][i]);
      if (e >= edges.size()) edges.resize(e + 1);
      edges[e].push_back({f, i});
    }
  }
  return edges;
}

Side OtherSide(const std::vector<Side>& edge, const Side& side) {
  return edge[0].face == side.face && edge[0].i == side.i ? edge[1] : edge[0];
}

// A corner of each vertex.
std::vector<Side> FirstCorners(const DooSabinMesh& mesh) {
  std::vector<Side> corners(mesh.points.size());
  for (std::size_t f = mesh.faces.size(); f-- > 0;) {
    for (std::size_t i = mesh.faces[f].size(); i-- > 0;) {
      corners[static_cast<std::size_t>(mesh.faces[f][i])] = {f, i};
    }
  }
  return corners;
}

// The topology of a Doo-Sabin step. The image of the i-th vertex of face f is vertex
// Image(f, i); the new edges lie inside a face along one of its sides, or across an edge between
// the two images of one of its ends.
class Step {
 public:
  explicit Step(const DooSabinMesh& mesh) : mesh_(mesh), edges_(SidesOfEdges(mesh)) {
    for (const Face& face : mesh.faces) {
      first_image_.push_back(corners_);
      corners_ += static_cast<int>(face.size());
    }
  }

  // Type-F faces, then type-E faces by edge, then type-V faces by vertex.
  DooSabinMesh Refine(const std::function<Points(const Points&)>& rule) {
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
      for (const Point& image : rule(mesh_.FacePoints(f))) refined_.points.push_back(image);
    }
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f) AddTypeF(f);
    for (std::size_t e = 0; e < edges_.size(); ++e) AddTypeE(e);
    const std::vector<Side> corners = FirstCorners(mesh_);
    for (const Side& corner : corners) AddTypeV(corner);
    return std::move(refined_);
  }

  const std::vector<std::vector<Side>>& edges() const { return edges_; }

 private:
  int Image(std::size_t face, std::size_t i) const {
    return first_image_[face] + static_cast<int>(i % mesh_.faces[face].size());
  }
  int Inside(const Side& side) const { return Image(side.face, side.i); }
  int Across(std::size_t edge, int end) const {
    const Side& side = edges_[edge][0];
    const bool first = mesh_.faces[side.face][side.i] == end;
    return corners_ + 2 * static_cast<int>(edge) + (first ? 0 : 1);
  }

  void AddTypeF(std::size_t f) {
    Face face;
    std::vector<int> sides;
    for (std::size_t i = 0; i < mesh_.faces[f].size(); ++i) {
      face.push_back(Image(f, i));
      sides.push_back(Inside({f, i}));
    }
    refined_.faces.push_back(face);
    refined_.sides.push_back(sides);
  }

  // Faces f (a -> b) and g (b -> a) share the edge: b in f, a in f, a in g, b in g.
  void AddTypeE(std::size_t e) {
    if (edges_[e].size() < 2) return;
    const Side f = edges_[e][0];
    const Side g = edges_[e][1];
    const int a = mesh_.faces[f.face][f.i];
    const int b = mesh_.faces[g.face][g.i];
    refined_.faces.push_back(
        {Image(f.face, f.i + 1), Image(f.face, f.i), Image(g.face, g.i + 1), Image(g.face, g.i)});
    refined_.sides.push_back({Inside(f), Across(e, a), Inside(g), Across(e, b)});
  }

  // The images of a vertex in the faces around it: the next face, counter-clockwise, is the one
  // across the edge that enters the vertex.
  void AddTypeV(const Side& start) {
    const int vertex = mesh_.faces[start.face][start.i];
    Face face;
    std::vector<int> sides;
    Side at = start;
    do {
      const std::size_t m = mesh_.faces[at.face].size();
      const Side entering = {at.face, (at.i + m - 1) % m};
      const auto e = static_cast<std::size_t>(mesh_.sides[at.face][entering.i]);
      face.push_back(Image(at.face, at.i));
      sides.push_back(Across(e, vertex));
      // A boundary vertex has no face of type V.
      if (edges_[e].size() < 2) return;
      at = OtherSide(edges_[e], entering);
    } while (at.face != start.face || at.i != start.i);
    refined_.faces.push_back(face);
    refined_.sides.push_back(sides);
  }

  const DooSabinMesh& mesh_;
  std::vector<std::vector<Side>> edges_;
  std::vector<int> first_image_;
  int corners_ = 0;
  DooSabinMesh refined_;
};

}  // namespace

std::vector<int> FacesAround(const Mesh& mesh) {
  std::vector<int> count(mesh.points.size(), 0);
  for (const Face& face : mesh.faces) {
    for (const int v : face) ++count[static_cast<std::size_t>(v)];
  }
  return count;
}

Matrix Equation6(const Mesh& mesh) {
  const std::size_t n = mesh.points.size();
  const std::vector<int> m = FacesAround(mesh);
  Matrix matrix(n, std::vector<Real>(n, 0));
  for (std::size_t v = 0; v < n; ++v) matrix[v][v] = m[v];
  // Every face around V adds 1/m_i to V, to E_i, to E_(i+1) and to each of its V_j: that makes
  // 1/m_i + 1/m_(i-1) for the edge neighbours.
  for (const Face& face : mesh.faces) {
    for (const int v : face) {
      for (const int u : face) {
        matrix[static_cast<std::size_t>(v)][static_cast<std::size_t>(u)] +=
            1 / static_cast<Real>(face.size());
      }
    }
  }
  return matrix;
}

Points SolveEquation6(const Mesh& given) {
  const std::vector<int> m = FacesAround(given);
  Points right;
  for (std::size_t v = 0; v < m.size(); ++v) {
    right.push_back(static_cast<Real>(2 * m[v]) * given.points[v]);
  }
  return SolveDense(Equation6(given), right);
}

namespace {

// V of Eq. 7 from these points.
Point Equation7(const Mesh& given, const std::vector<Real>& row, int m, const Points& points,
                std::size_t v) {
  Point sum = static_cast<Real>(2 * m) * given.points[v];
  for (std::size_t u = 0; u < points.size(); ++u) {
    if (u != v) sum = sum - row[u] * points[u];
  }
  return (1 / row[v]) * sum;
}

}  // namespace

Points JacobiSweep(const Mesh& given, const Points& before) {
  const Matrix matrix = Equation6(given);
  const std::vector<int> m = FacesAround(given);
  Points after;
  for (std::size_t v = 0; v < before.size(); ++v) {
    after.push_back(Equation7(given, matrix[v], m[v], before, v));
  }
  return after;
}

Points GaussSeidelSweep(const Mesh& given, Points points) {
  const Matrix matrix = Equation6(given);
  const std::vector<int> m = FacesAround(given);
  for (std::size_t v = 0; v < points.size(); ++v) {
    points[v] = Equation7(given, matrix[v], m[v], points, v);
  }
  return points;
}

Points Equation1(const Points& face) {
  const std::size_t m = face.size();
  // alpha[d] is alpha_ij for (i - j) mod m = d.
  std::vector<Real> alpha;
  for (std::size_t d = 0; d < m; ++d) {
    const Real angle = 2 * kPi * static_cast<Real>(d) / m;
    alpha.push_back(d == 0 ? (m + 5) / static_cast<Real>(4 * m)
                           : (3 + 2 * std::cos(angle)) / static_cast<Real>(4 * m));
  }
  Points images(m);
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t j = 0; j < m; ++j) images[i] = images[i] + alpha[(i + m - j) % m] * face[j];
  }
  return images;
}

Points Equation4(const Points& face) {
  const Point centroid = Centroid(face);
  Points images;
  for (const Point& p : face) images.push_back(0.5L * (p + centroid));
  return images;
}

Point Equation10(const Points& face) {
  Point sum;
  for (std::size_t i = 0; i < face.size(); ++i) {
    sum = sum + Cross(face[i], face[(i + 1) % face.size()]);
  }
  return Unit(sum);
}

Points Equation17(const Points& face, const Point& target) {
  const Point centroid = Centroid(face);
  // Without area there is no plane to move into.
  Point sum;
  Real size = 0;
  for (std::size_t i = 0; i < face.size(); ++i) {
    sum = sum + Cross(face[i] - centroid, face[(i + 1) % face.size()] - centroid);
    size = std::max(size, Norm(face[i] - centroid));
  }
  const bool flat = Norm(sum) <= 1e-12L * size * size;
  const Point n = flat ? Point{} : Equation10(face);
  Points moved;
  for (const Point& w : face) {
    const Point epsilon = Dot(centroid - w, n) * n + (target - centroid);
    moved.push_back(w + epsilon);
  }
  return moved;
}

Points DooSabinMesh::FacePoints(std::size_t face) const {
  Points result;
  for (const int v : faces[face]) result.push_back(points[static_cast<std::size_t>(v)]);
  return result;
}

DooSabinMesh Start(const Mesh& mesh) {
  DooSabinMesh result;
  result.points = mesh.points;
  result.faces = mesh.faces;
  const EdgeNumbers edges = NumberEdges(mesh.faces);
  for (const Face& face : mesh.faces) {
    std::vector<int> sides;
    for (std::size_t i = 0; i < face.size(); ++i) {
      sides.push_back(edges.at(EdgeKey(face[i], face[(i + 1) % face.size()])));
    }
    result.sides.push_back(sides);
  }
  return result;
}

DooSabinMesh RefineFirst(const DooSabinMesh& mesh, const Tiling& tiling) {
  Step step(mesh);
  DooSabinMesh refined = step.Refine(Equation4);
  const int vertices = tiling.vertex_count;
  const int edges = static_cast<int>(step.edges().size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    refined.tile_vertex.push_back(vertices + edges + static_cast<int>(f));
  }
  // The edges of M^0 are numbered as those of T^0.
  for (int e = 0; e < edges; ++e) refined.tile_vertex.push_back(vertices + e);
  for (int v = 0; v < vertices; ++v) refined.tile_vertex.push_back(v);
  return refined;
}

DooSabinMesh Refine(const DooSabinMesh& mesh, const Tiling& tiling) {
  Step step(mesh);
  DooSabinMesh refined = step.Refine(Equation1);
  const EdgeNumbers tile_edges = NumberEdges(tiling.faces);
  const int first_edge = tiling.vertex_count;
  const int first_face = first_edge + static_cast<int>(tile_edges.size());
  refined.tile_vertex = mesh.tile_vertex;
  for (const std::vector<Side>& edge : step.edges()) {
    if (edge.size() < 2) continue;
    const auto key = EdgeKey(mesh.tile_vertex[edge[0].face], mesh.tile_vertex[edge[1].face]);
    refined.tile_vertex.push_back(first_edge + tile_edges.at(key));
  }
  for (const int tile : TileOfVertex(mesh, tiling)) {
    if (tile < 0) continue;
    refined.tile_vertex.push_back(first_face + tile);
  }
  return refined;
}

void Perturb(const Points& given, DooSabinMesh* first_refined) {
  const int vertices = static_cast<int>(given.size());
  for (std::size_t f = 0; f < first_refined->faces.size(); ++f) {
    if (first_refined->tile_vertex[f] >= vertices) continue;
    const Point& target = given[static_cast<std::size_t>(first_refined->tile_vertex[f])];
    const Points moved = Equation17(first_refined->FacePoints(f), target);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      first_refined->points[static_cast<std::size_t>(first_refined->faces[f][i])] = moved[i];
    }
  }
}

std::vector<int> TileOfVertex(const DooSabinMesh& mesh, const Tiling& tiling) {
  std::map<Face, int> tile_of;
  for (std::size_t t = 0; t < tiling.faces.size(); ++t) {
    Face key = tiling.faces[t];
    std::sort(key.begin(), key.end());
    tile_of[key] = static_cast<int>(t);
  }
  std::vector<Face> around(mesh.points.size());
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (const int v : mesh.faces[f]) {
      around[static_cast<std::size_t>(v)].push_back(mesh.tile_vertex[f]);
    }
  }
  std::vector<int> tiles;
  for (Face& key : around) {
    std::sort(key.begin(), key.end());
    const auto tile = tile_of.find(key);
    tiles.push_back(tile == tile_of.end() ? -1 : tile->second);
  }
  return tiles;
}

Points InTileOrder(const DooSabinMesh& mesh, const Tiling& tiling) {
  const std::vector<int> tiles = TileOfVertex(mesh, tiling);
  Points result(mesh.points.size());
  for (std::size_t v = 0; v < tiles.size(); ++v) {
    result.at(static_cast<std::size_t>(tiles[v])) = mesh.points[v];
  }
  return result;
}

Points LimitPoints(const DooSabinMesh& mesh, const Tiling& tiling) {
  Points limits(static_cast<std::size_t>(tiling.vertex_count));
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    limits.at(static_cast<std::size_t>(mesh.tile_vertex[f])) = Centroid(mesh.FacePoints(f));
  }
  return limits;
}

Point DeepNormal(const Points& face) {
  if (face.size() < 3) return {};
  const Point centroid = Centroid(face);
  Points offsets;
  for (const Point& p : face) offsets.push_back(p - centroid);
  // What the refinements halve is doubled again: the rest dies away.
  for (int step = 0; step < 60; ++step) {
    offsets = Equation1(offsets);
    for (Point& offset : offsets) offset = 2.0L * offset;
  }
  Point sum;
  Real spread = 0;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    sum = sum + Cross(offsets[i], offsets[(i + 1) % offsets.size()]);
    spread += Dot(offsets[i], offsets[i]);
  }
  return Norm(sum) <= 1e-12L * spread ? Point{} : Unit(sum);
}

Points DeepNormals(const DooSabinMesh& mesh, const Tiling& tiling) {
  Points normals(static_cast<std::size_t>(tiling.vertex_count));
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    normals.at(static_cast<std::size_t>(mesh.tile_vertex[f])) = DeepNormal(mesh.FacePoints(f));
  }
  return normals;
}

Interpolated InterpolateDooSabin(const Mesh& given, const Points& control, int level) {
  Interpolated result;
  result.control = control;
  Tiling tiling = TilingOf(given);
  DooSabinMesh mesh = RefineFirst(Start({control, given.faces}), tiling);
  tiling = Split(tiling);
  Perturb(given.points, &mesh);
  for (int k = 1; k < level; ++k) {
    mesh = Refine(mesh, tiling);
    tiling = Split(tiling);
  }
  result.points = LimitPoints(mesh, tiling);
  result.normals = DeepNormals(mesh, tiling);
  result.tiling = tiling;
  return result;
}

}  // namespace limn::oracle
