// SPDX-License-Identifier: MIT
#include "tests/oracle/test_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "engine/mesh/generate.h"

namespace limn::oracle {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

Vec3 OnCircle(int i, int n, double z, double turn = 0) {
  const double angle = kTwoPi * (i + turn) / n;
  return {std::cos(angle), std::sin(angle), z};
}

Index I(int i) { return static_cast<Index>(i); }

void Add(PolygonMesh* mesh, const std::vector<Index>& face) { mesh->AddFace(face); }

// 0 1 ... n-1, from `first` on.
std::vector<Index> Ring(int n, int first) {
  std::vector<Index> ring;
  for (int i = 0; i < n; ++i) ring.push_back(I(first + i));
  return ring;
}

std::vector<Index> Reversed(std::vector<Index> face) {
  std::reverse(face.begin(), face.end());
  return face;
}

// A grid around a torus; the faces are added by `add` from the four corners of each cell.
PolygonMesh Torus(int around, int across,
                  const std::function<void(PolygonMesh*, const std::array<Index, 4>&)>& add) {
  PolygonMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const Vec3 tube = OnCircle(j, across, 0);
      const Vec3 ring = OnCircle(i, around, 0);
      const double radius = 3 + tube.x;
      mesh.positions.push_back({radius * ring.x, radius * ring.y, tube.y});
    }
  }
  const auto at = [&](int i, int j) { return I((i % around) * across + j % across); };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      add(&mesh, {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

PolygonMesh Appended(PolygonMesh mesh, const PolygonMesh& more, const Vec3& offset) {
  const Index first = static_cast<Index>(mesh.vertex_count());
  for (const Vec3& p : more.positions) mesh.positions.push_back(p + offset);
  for (std::size_t f = 0; f < more.face_count(); ++f) {
    std::vector<Index> face(more.face(f).begin(), more.face(f).end());
    for (Index& v : face) v += first;
    Add(&mesh, face);
  }
  return mesh;
}

PolygonMesh Generated(MeshKind kind, std::uint64_t vertices, std::uint64_t seed) {
  auto mesh = GenerateMesh({.kind = kind, .vertices = vertices, .seed = seed});
  if (!mesh.ok()) throw std::runtime_error(mesh.status().ToString());
  return *std::move(mesh);
}

using Maker = std::function<PolygonMesh()>;

const std::vector<std::pair<std::string, Maker>>& ClosedMakers() {
  static const auto* const kMakers = [] {
    auto* const makers = new std::vector<std::pair<std::string, Maker>>{
        {"tetrahedron", Tetrahedron},
        {"cube", Cube},
        {"octahedron", Octahedron},
        {"dodecahedron", Dodecahedron},
        {"two_components", TwoComponents},
        {"genus_three", GenusThree},
        {"valence_two", CubeWithVertexOfValenceTwo},
        {"torus_of_quads", [] { return TorusOfQuads(7, 5); }},
        {"torus_of_triangles", [] { return TorusOfTriangles(6, 4); }},
        {"smallest_torus", [] { return TorusOfQuads(3, 3); }},
        {"cube_jittered_seed_3", [] { return Jittered(Cube(), 3, 0.4); }},
        {"prism_7_jittered_seed_4", [] { return Jittered(Prism(7), 4, 0.3); }},
        {"torus_jittered_seed_5", [] { return Jittered(TorusOfTriangles(9, 7), 5, 0.3); }},
    };
    for (const int n : {3, 5, 6, 8, 40}) {
      makers->emplace_back("prism_" + std::to_string(n), [n] { return Prism(n); });
    }
    for (const int n : {4, 5, 40}) {
      makers->emplace_back("antiprism_" + std::to_string(n), [n] { return Antiprism(n); });
    }
    for (const int n : {3, 5, 33, 200}) {
      makers->emplace_back("double_pyramid_" + std::to_string(n), [n] { return DoublePyramid(n); });
    }
    for (const int n : {3, 4, 9}) {
      makers->emplace_back("pillow_" + std::to_string(n), [n] { return Pillow(n); });
    }
    for (const MeshKind kind : AllMeshKinds()) {
      if (!IsClosedKind(kind)) continue;
      for (const std::uint64_t seed : {1, 2}) {
        const std::string name = std::string(MeshKindName(kind)) + "_seed_" + std::to_string(seed);
        makers->emplace_back(name, [=] { return Generated(kind, 120 + 20 * seed, seed); });
        makers->emplace_back(name + "_shuffled",
                             [=] { return Shuffled(Generated(kind, 90, seed), seed); });
      }
    }
    return makers;
  }();
  return *kMakers;
}

}  // namespace

PolygonMesh MakeMesh(std::initializer_list<Vec3> positions,
                     std::initializer_list<std::initializer_list<Index>> faces) {
  PolygonMesh mesh;
  mesh.positions.assign(positions.begin(), positions.end());
  for (const auto& face : faces) Add(&mesh, face);
  return mesh;
}

PolygonMesh Tetrahedron() {
  return MakeMesh({{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}},
                  {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
}

PolygonMesh Cube() { return CubesSurface({{0, 0, 0}}); }

PolygonMesh Octahedron() { return DoublePyramid(4); }

PolygonMesh Dodecahedron() {
  const double phi = std::numbers::phi;
  PolygonMesh mesh;
  for (const double x : {-1., 1.}) {
    for (const double y : {-1., 1.}) {
      for (const double z : {-1., 1.}) mesh.positions.push_back({x, y, z});
      mesh.positions.push_back({0, x / phi, y * phi});
      mesh.positions.push_back({x / phi, y * phi, 0});
      mesh.positions.push_back({y * phi, 0, x / phi});
    }
  }
  // Each face lies across one vertex of an icosahedron: the five vertices furthest that way, in
  // the order of their angles.
  for (const double a : {-1., 1.}) {
    for (const double b : {-1., 1.}) {
      for (const Vec3& axis : {Vec3{0, a * phi, b}, Vec3{a * phi, b, 0}, Vec3{b, 0, a * phi}}) {
        const Vec3 u = NormalizedOrZero(Cross(axis, {0.3, 0.5, 0.7}));
        const Vec3 v = NormalizedOrZero(Cross(axis, u));
        std::vector<std::pair<double, Index>> ring;
        for (std::size_t i = 0; i < mesh.vertex_count(); ++i) {
          const Vec3& p = mesh.positions[i];
          if (Dot(p, axis) > 0.9 * (1 + phi)) {
            ring.emplace_back(std::atan2(Dot(p, v), Dot(p, u)), static_cast<Index>(i));
          }
        }
        std::sort(ring.begin(), ring.end());
        std::vector<Index> face;
        for (const auto& [angle, vertex] : ring) face.push_back(vertex);
        Add(&mesh, face);
      }
    }
  }
  return mesh;
}

PolygonMesh Prism(int n) {
  PolygonMesh mesh;
  for (const double z : {0., 1.}) {
    for (int i = 0; i < n; ++i) mesh.positions.push_back(OnCircle(i, n, z));
  }
  Add(&mesh, Reversed(Ring(n, 0)));
  Add(&mesh, Ring(n, n));
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    Add(&mesh, {I(i), I(j), I(n + j), I(n + i)});
  }
  return mesh;
}

PolygonMesh Antiprism(int n) {
  PolygonMesh mesh;
  for (int i = 0; i < n; ++i) mesh.positions.push_back(OnCircle(i, n, 0));
  for (int i = 0; i < n; ++i) mesh.positions.push_back(OnCircle(i, n, 1, 0.5));
  Add(&mesh, Reversed(Ring(n, 0)));
  Add(&mesh, Ring(n, n));
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    Add(&mesh, {I(i), I(j), I(n + i)});
    Add(&mesh, {I(j), I(n + j), I(n + i)});
  }
  return mesh;
}

PolygonMesh DoublePyramid(int n) {
  PolygonMesh mesh;
  mesh.positions.push_back({0, 0, 1});
  mesh.positions.push_back({0, 0, -1});
  for (int i = 0; i < n; ++i) mesh.positions.push_back(OnCircle(i, n, 0));
  for (int i = 0; i < n; ++i) {
    const Index a = I(2 + i);
    const Index b = I(2 + (i + 1) % n);
    Add(&mesh, {0, a, b});
    Add(&mesh, {1, b, a});
  }
  return mesh;
}

PolygonMesh TorusOfQuads(int around, int across) {
  return Torus(around, across, [](PolygonMesh* mesh, const std::array<Index, 4>& cell) {
    Add(mesh, {cell[0], cell[1], cell[2], cell[3]});
  });
}

PolygonMesh TorusOfTriangles(int around, int across) {
  return Torus(around, across, [](PolygonMesh* mesh, const std::array<Index, 4>& cell) {
    Add(mesh, {cell[0], cell[1], cell[2]});
    Add(mesh, {cell[0], cell[2], cell[3]});
  });
}

PolygonMesh TwoComponents() { return Appended(Tetrahedron(), Cube(), {4, 1, 0}); }

PolygonMesh CubesSurface(const std::set<std::array<int, 3>>& cubes) {
  PolygonMesh mesh;
  std::map<std::array<int, 3>, Index> numbers;
  const auto number = [&](const std::array<int, 3>& p) {
    const auto [at, fresh] = numbers.emplace(p, static_cast<Index>(mesh.positions.size()));
    if (fresh) {
      mesh.positions.push_back(
          {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    }
    return at->second;
  };
  for (const auto& cube : cubes) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int side : {0, 1}) {
        std::array<int, 3> neighbour = cube;
        neighbour[axis] += side == 1 ? 1 : -1;
        if (cubes.count(neighbour) != 0) continue;
        std::vector<Index> face;
        for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
          std::array<int, 3> corner = cube;
          corner[axis] += side;
          corner[(axis + 1) % 3] += u;
          corner[(axis + 2) % 3] += v;
          face.push_back(number(corner));
        }
        Add(&mesh, side == 1 ? face : Reversed(face));
      }
    }
  }
  return mesh;
}

PolygonMesh GenusThree() {
  std::set<std::array<int, 3>> cubes;
  for (int x = 0; x < 7; ++x) {
    for (int y = 0; y < 3; ++y) {
      if (y != 1 || x % 2 == 0) cubes.insert({x, y, 0});
    }
  }
  return CubesSurface(cubes);
}

PolygonMesh CubeWithVertexOfValenceTwo() {
  const PolygonMesh cube = Cube();
  PolygonMesh mesh;
  mesh.positions = cube.positions;
  const Index a = cube.corner_vertex[0];
  const Index b = cube.corner_vertex[1];
  const Index middle = static_cast<Index>(cube.vertex_count());
  mesh.positions.push_back(0.5 * (cube.positions[a] + cube.positions[b]) + Vec3{0.1, -0.2, -0.1});
  for (std::size_t f = 0; f < cube.face_count(); ++f) {
    std::vector<Index> face;
    const auto old = cube.face(f);
    for (std::size_t i = 0; i < old.size(); ++i) {
      const Index next = old[(i + 1) % old.size()];
      face.push_back(old[i]);
      if (std::minmax(old[i], next) == std::minmax(a, b)) face.push_back(middle);
    }
    Add(&mesh, face);
  }
  return mesh;
}

PolygonMesh Pillow(int n) {
  PolygonMesh mesh;
  for (int i = 0; i < n; ++i) mesh.positions.push_back(OnCircle(i, n, 0.25 * (i % 3)));
  Add(&mesh, Ring(n, 0));
  Add(&mesh, Reversed(Ring(n, 0)));
  return mesh;
}

PolygonMesh Jittered(PolygonMesh mesh, std::uint64_t seed, double amount) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> offset(-amount, amount);
  for (Vec3& p : mesh.positions) {
    p.x += offset(random);
    p.y += offset(random);
    p.z += offset(random);
  }
  return mesh;
}

PolygonMesh Moved(PolygonMesh mesh, double factor, const Vec3& offset) {
  for (Vec3& p : mesh.positions) p = factor * p + offset;
  return mesh;
}

PolygonMesh Shuffled(const PolygonMesh& mesh, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Index> place(mesh.vertex_count());
  for (std::size_t v = 0; v < place.size(); ++v) place[v] = static_cast<Index>(v);
  std::shuffle(place.begin(), place.end(), random);
  std::vector<std::vector<Index>> faces;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    std::vector<Index> face;
    for (const Index v : mesh.face(f)) face.push_back(place[v]);
    std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(random() % face.size()),
                face.end());
    faces.push_back(face);
  }
  std::shuffle(faces.begin(), faces.end(), random);
  PolygonMesh shuffled;
  shuffled.positions.resize(mesh.vertex_count());
  for (std::size_t v = 0; v < place.size(); ++v) shuffled.positions[place[v]] = mesh.positions[v];
  for (const auto& face : faces) Add(&shuffled, face);
  return shuffled;
}

PolygonMesh Triangulated(const PolygonMesh& mesh) {
  PolygonMesh triangles;
  triangles.positions = mesh.positions;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    if (face.size() == 3) {
      triangles.AddFace(face);
      continue;
    }
    Vec3 sum = {0, 0, 0};
    for (const Index v : face) sum += mesh.positions[v];
    const Index middle = static_cast<Index>(triangles.vertex_count());
    triangles.positions.push_back((1.0 / static_cast<double>(face.size())) * sum);
    for (std::size_t i = 0; i < face.size(); ++i) {
      Add(&triangles, {face[i], face[(i + 1) % face.size()], middle});
    }
  }
  return triangles;
}

std::vector<std::string> ClosedMeshNames() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : ClosedMakers()) names.push_back(name);
  return names;
}

PolygonMesh ClosedMesh(const std::string& name) {
  for (const auto& [known, maker] : ClosedMakers()) {
    if (known == name) return maker();
  }
  throw std::runtime_error("no test mesh " + name);
}

std::vector<BrokenMesh> BrokenMeshes() {
  std::vector<BrokenMesh> broken;
  const auto add = [&](const std::string& name, const PolygonMesh& mesh, Reason reason,
                       const std::string& field, const std::pair<int, int>& count_and_first) {
    broken.push_back({name, mesh, reason, field, static_cast<std::uint64_t>(count_and_first.first),
                      static_cast<std::uint64_t>(count_and_first.second)});
  };
  const auto replaced = [](PolygonMesh mesh, std::size_t corner, Index vertex) {
    mesh.corner_vertex[corner] = vertex;
    return mesh;
  };

  PolygonMesh small = Tetrahedron();
  Add(&small, {0, 1});
  Add(&small, {});
  add("faces_too_small", small, Reason::kFaceTooSmall, "mesh.faces", {2, 4});

  add("index_out_of_range", replaced(Cube(), 9, 8), Reason::kIndexOutOfRange, "mesh.faces", {1, 2});
  add("index_far_out_of_range", replaced(Cube(), 23, kNoIndex), Reason::kIndexOutOfRange,
      "mesh.faces", {1, 5});

  const PolygonMesh cube = Cube();
  add("repeated_vertex", replaced(cube, 6, cube.corner_vertex[4]), Reason::kRepeatedVertex,
      "mesh.faces", {1, 1});
  PolygonMesh long_face = Prism(40);
  long_face.corner_vertex[39] = long_face.corner_vertex[3];
  add("repeated_vertex_in_long_face", long_face, Reason::kRepeatedVertex, "mesh.faces", {1, 0});

  PolygonMesh fin = Tetrahedron();
  fin.positions.push_back({3, 3, 3});
  Add(&fin, {1, 2, 4});
  add("three_faces_at_an_edge", fin, Reason::kNonManifoldEdge, "mesh.faces", {1, 0});
  PolygonMesh twice = Tetrahedron();
  Add(&twice, {0, 2, 1});
  add("face_given_twice", twice, Reason::kNonManifoldEdge, "mesh.faces", {3, 0});
  PolygonMesh hub = DoublePyramid(100);
  hub.positions.push_back({3, 3, 3});
  Add(&hub, {0, 50, 102});
  add("three_faces_at_an_edge_of_a_hub", hub, Reason::kNonManifoldEdge, "mesh.faces", {1, 94});

  PolygonMesh flipped = Cube();
  std::reverse(flipped.corner_vertex.begin() + 12, flipped.corner_vertex.begin() + 16);
  add("flipped_face", flipped, Reason::kInconsistentOrientation, "mesh.faces", {4, 0});
  // No half-edge has a partner here, in either direction.
  add("two_faces_the_same_way",
      MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2}, {0, 1, 3}}),
      Reason::kInconsistentOrientation, "mesh.faces", {1, 0});

  PolygonMesh bow_tie = Appended(Tetrahedron(), Tetrahedron(), {2, 2, 2});
  for (Index& v : bow_tie.corner_vertex) {
    if (v == 5) v = 0;
    if (v > 5) --v;
  }
  bow_tie.positions.erase(bow_tie.positions.begin() + 5);
  add("two_fans_at_a_vertex", bow_tie, Reason::kNonManifoldVertex, "mesh.vertices", {1, 0});
  add("two_open_fans_at_a_vertex",
      MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{1, 2, 0}, {3, 4, 0}}),
      Reason::kNonManifoldVertex, "mesh.vertices", {1, 0});

  PolygonMesh isolated = Cube();
  isolated.positions.push_back({5, 5, 5});
  isolated.positions.push_back({6, 5, 5});
  add("isolated_vertices", isolated, Reason::kIsolatedVertex, "mesh.vertices", {2, 8});
  return broken;
}

}  // namespace limn::oracle
