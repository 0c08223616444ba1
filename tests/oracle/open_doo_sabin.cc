// SPDX-License-Identifier: MIT
#include "tests/oracle/open_doo_sabin.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

namespace limn::oracle {
namespace {

constexpr Real kPi = std::numbers::pi_v<Real>;

std::size_t At(int i) { return static_cast<std::size_t>(i); }

// Weights of a face's points in the image of its first point.
std::vector<Real> ImageWeights(std::size_t m, bool standard) {
  std::vector<Real> weights(m);
  for (std::size_t d = 0; d < m; ++d) {
    Points unit(m);
    unit[d].x = 1;
    weights[d] = (standard ? Equation1(unit) : Equation4(unit))[0].x;
  }
  return weights;
}

// One type-V face with what belongs to it.
class FaceOfVertex {
 public:
  FaceOfVertex(const Mesh& given, const Wishes& wishes, int vertex)
      : wishes_(wishes), vertex_(vertex), target_(given.points[At(vertex)]) {}

  // Eq. 17 and Brunet's scaling. sharp: a corner of the boundary.
  Points Perturb(const Points& face, bool sharp) const {
    const Point centroid = Centroid(face);
    const bool meets = wishes_.meets(vertex_);
    Points result = face;
    if (meets) {
      const auto normal = wishes_.normals.find(vertex_);
      if (normal == wishes_.normals.end()) {
        result = Equation17(face, target_);
      } else {
        const Point n = Unit(normal->second);
        for (Point& w : result) w = w + Dot(centroid - w, n) * n + (target_ - centroid);
      }
    }
    const auto handle = wishes_.handles.find(vertex_);
    if (handle == wishes_.handles.end()) return result;
    const Point centre = meets || sharp ? target_ : centroid;
    for (Point& w : result) w = centre + handle->second * (w - centre);
    return result;
  }

 private:
  const Wishes& wishes_;
  int vertex_;
  Point target_;
};

// Builds M^1 face by face.
class FirstRefined {
 public:
  FirstRefined(const Mesh& given, const Points& control, const Wishes& wishes)
      : given_(given),
        control_(control),
        wishes_(wishes),
        fans_(FansOf(given)),
        edges_(NumberEdges(given.faces)) {}

  DooSabinMesh Build() {
    for (const Face& face : given_.faces) {
      first_.push_back(static_cast<int>(mesh_.points.size()));
      Points points;
      for (const int v : face) points.push_back(control_[At(v)]);
      for (const Point& p : wishes_.standard_rule ? Equation1(points) : Equation4(points)) {
        mesh_.points.push_back(p);
      }
    }
    if (!wishes_.images.empty()) mesh_.points = wishes_.images;
    corners_ = static_cast<int>(mesh_.points.size());
    rim_ = corners_ + 2 * static_cast<int>(edges_.size());
    const int vertices = static_cast<int>(given_.points.size());
    for (std::size_t f = 0; f < given_.faces.size(); ++f) {
      Add(FaceF(f), vertices + static_cast<int>(edges_.size() + f));
    }
    for (int v = 0; v < vertices; ++v) AddV(v);
    for (std::size_t f = 0; f < given_.faces.size(); ++f) AddE(static_cast<int>(f), vertices);
    return std::move(mesh_);
  }

 private:
  struct Drawn {
    Face face;
    std::vector<int> sides;
  };

  int Image(int face, int place) const {
    const int m = static_cast<int>(given_.faces[At(face)].size());
    return first_[At(face)] + (place + m) % m;
  }
  int EdgeOf(int a, int b) const { return edges_.at(EdgeKey(a, b)); }
  // The edge of M^1 between the type-E face of an edge and the type-V face of its end `end`.
  int Across(int a, int b, int end) const {
    return corners_ + 2 * EdgeOf(a, b) + (end == std::min(a, b) ? 0 : 1);
  }
  void Add(const Drawn& drawn, int tile) {
    mesh_.faces.push_back(drawn.face);
    mesh_.sides.push_back(drawn.sides);
    mesh_.tile_vertex.push_back(tile);
  }
  int NewPoint(const Point& p) {
    mesh_.points.push_back(p);
    return static_cast<int>(mesh_.points.size()) - 1;
  }
  Point Curve(int v, int other) const {
    const auto known = wishes_.curve.find({v, other});
    if (known != wishes_.curve.end()) return known->second;
    return 0.25L * (3.0L * control_[At(v)] + control_[At(other)]);
  }

  Drawn FaceF(std::size_t f) const {
    Drawn drawn;
    for (std::size_t i = 0; i < given_.faces[f].size(); ++i) {
      drawn.face.push_back(Image(static_cast<int>(f), static_cast<int>(i)));
      drawn.sides.push_back(drawn.face.back());
    }
    return drawn;
  }

  void AddV(int v) {
    const Fan& fan = fans_[At(v)];
    Drawn drawn;
    for (const Corner& corner : fan.corners) {
      const Face& face = given_.faces[At(corner.face)];
      const int before = face[At(corner.place + static_cast<int>(face.size()) - 1) % face.size()];
      drawn.face.push_back(Image(corner.face, corner.place));
      drawn.sides.push_back(Across(before, v, v));
    }
    const bool sharp = fan.boundary && fan.corners.size() == 1;
    if (fan.boundary) AddGhosts(v, fan, &drawn);
    Points points;
    for (const int p : drawn.face) points.push_back(mesh_.points[At(p)]);
    points = FaceOfVertex(given_, wishes_, v).Perturb(points, sharp);
    for (std::size_t i = 0; i < points.size(); ++i) mesh_.points[At(drawn.face[i])] = points[i];
    Add(drawn, v);
  }

  void AddGhosts(int v, const Fan& fan, Drawn* drawn) {
    const std::size_t m = fan.corners.size();
    const Point out = Curve(v, fan.next);
    const Point in = Curve(v, fan.previous);
    Points ghosts;
    if (m == 1) {
      const Point w = mesh_.points[At(drawn->face[0])];
      const Point ghost_in = 2.0L * in - w;
      const Point ghost_out = 2.0L * out - w;
      ghosts = {ghost_in, 4.0L * given_.points[At(v)] - w - ghost_in - ghost_out, ghost_out};
    } else {
      const Point c = 0.5L * (out + in);
      const Point d = 0.5L * (out - in);
      for (std::size_t j = m; j >= 1; --j) {
        const Real spread = std::cos((static_cast<Real>(j) - 0.5L) * kPi / static_cast<Real>(m)) /
                            std::cos(kPi / static_cast<Real>(2 * m));
        ghosts.push_back(2.0L * (c + spread * d) - mesh_.points[At(drawn->face[j - 1])]);
      }
    }
    for (const Point& ghost : ghosts) {
      drawn->face.push_back(NewPoint(ghost));
      drawn->sides.push_back(rim_++);
    }
    // The last side closes the face along the leaving edge.
    drawn->sides.back() = Across(v, fan.next, v);
    ghost_out_[v] = drawn->face.back();
    ghost_in_[v] = drawn->face[m];
  }

  void AddE(int f, int vertices) {
    const Face& face = given_.faces[At(f)];
    for (int i = 0; i < static_cast<int>(face.size()); ++i) {
      const int a = face[At(i)];
      const int b = face[At(i + 1) % face.size()];
      Drawn drawn;
      drawn.face = {Image(f, i + 1), Image(f, i)};
      const Corner across = Opposite(f, a, b);
      int rim = 0;
      if (across.face < 0) {
        drawn.face.push_back(ghost_out_.at(a));
        drawn.face.push_back(ghost_in_.at(b));
        rim = rim_++;
      } else {
        // Each edge once.
        if (across.face < f) continue;
        drawn.face.push_back(Image(across.face, across.place + 1));
        drawn.face.push_back(Image(across.face, across.place));
        rim = Image(across.face, across.place);
      }
      drawn.sides = {Image(f, i), Across(a, b, a), rim, Across(a, b, b)};
      Add(drawn, vertices + EdgeOf(a, b));
    }
  }

  // The corner at b of the face on the other side of a -> b, or face -1.
  Corner Opposite(int f, int a, int b) const {
    for (std::size_t g = 0; g < given_.faces.size(); ++g) {
      const Face& face = given_.faces[g];
      for (std::size_t i = 0; i < face.size(); ++i) {
        if (static_cast<int>(g) != f && face[i] == b && face[(i + 1) % face.size()] == a) {
          return {static_cast<int>(g), static_cast<int>(i)};
        }
      }
    }
    return {-1, -1};
  }

  const Mesh& given_;
  const Points& control_;
  const Wishes& wishes_;
  const std::vector<Fan> fans_;
  const EdgeNumbers edges_;
  std::vector<int> first_;
  int corners_ = 0;
  int rim_ = 0;
  std::map<int, int> ghost_out_;
  std::map<int, int> ghost_in_;
  DooSabinMesh mesh_;
};

}  // namespace

std::vector<Fan> FansOf(const Mesh& mesh) {
  // Corner at the start of each directed edge.
  std::map<std::pair<int, int>, Corner> corner_of;
  std::vector<Corner> first(mesh.points.size(), {-1, -1});
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Face& face = mesh.faces[f];
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Corner corner = {static_cast<int>(f), static_cast<int>(i)};
      corner_of[{face[i], face[(i + 1) % face.size()]}] = corner;
      if (first[At(face[i])].face < 0) first[At(face[i])] = corner;
    }
  }
  std::vector<Fan> fans(mesh.points.size());
  for (std::size_t v = 0; v < fans.size(); ++v) {
    const int vertex = static_cast<int>(v);
    const auto neighbour = [&](const Corner& c, int step) {
      const Face& face = mesh.faces[At(c.face)];
      return face[At(c.place + step + static_cast<int>(face.size())) % face.size()];
    };
    Corner start = first[v];
    // Clockwise until the boundary, or all round.
    while (true) {
      const auto across = corner_of.find({neighbour(start, 1), vertex});
      if (across == corner_of.end()) {
        fans[v].boundary = true;
        break;
      }
      const Corner c = across->second;
      start = {c.face, (c.place + 1) % static_cast<int>(mesh.faces[At(c.face)].size())};
      if (start.face == first[v].face) break;
    }
    fans[v].next = neighbour(start, 1);
    Corner at = start;
    while (true) {
      fans[v].corners.push_back(at);
      fans[v].previous = neighbour(at, -1);
      const auto across = corner_of.find({vertex, neighbour(at, -1)});
      if (across == corner_of.end()) break;
      at = across->second;
      if (at.face == start.face) break;
    }
  }
  return fans;
}

Points SolveOpen(const Mesh& given, const Wishes& wishes) {
  const std::size_t n = given.points.size();
  const std::vector<Fan> fans = FansOf(given);
  Matrix matrix(n, std::vector<Real>(n, 0));
  for (std::size_t v = 0; v < n; ++v) {
    const Fan& fan = fans[v];
    const std::size_t m = fan.corners.size();
    if (!wishes.meets(static_cast<int>(v)) || (fan.boundary && m == 1)) {
      matrix[v][v] = 1;
    } else if (fan.boundary) {
      matrix[v][v] = 0.75L;
      matrix[v][At(fan.next)] += 0.125L;
      matrix[v][At(fan.previous)] += 0.125L;
    } else {
      for (const Corner& corner : fan.corners) {
        const Face& face = given.faces[At(corner.face)];
        const std::vector<Real> weights = ImageWeights(face.size(), wishes.standard_rule);
        for (std::size_t d = 0; d < face.size(); ++d) {
          const int u = face[(At(corner.place) + d) % face.size()];
          matrix[v][At(u)] += weights[d] / static_cast<Real>(m);
        }
      }
    }
  }
  return SolveDense(matrix, given.points);
}

DooSabinMesh OpenFirstRefined(const Mesh& given, const Points& control, const Wishes& wishes) {
  return FirstRefined(given, control, wishes).Build();
}

Interpolated InterpolateOpen(const Mesh& given, const Wishes& wishes, int level) {
  Interpolated result;
  result.control = SolveOpen(given, wishes);
  DooSabinMesh mesh = OpenFirstRefined(given, result.control, wishes);
  Tiling tiling = Split(TilingOf(given));
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
