// SPDX-License-Identifier: MIT
#include "tests/oracle/open_meshes.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "tests/oracle/test_meshes.h"

namespace limn::oracle {
namespace {

Vec3 OnCircle(int i, int n, double radius, double z) {
  const double angle = 2 * std::numbers::pi * i / n;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

void Add(PolygonMesh* mesh, std::initializer_list<int> face) {
  std::vector<Index> vertices;
  for (const int v : face) vertices.push_back(static_cast<Index>(v));
  mesh->AddFace(vertices);
}

PolygonMesh Without(const PolygonMesh& mesh, std::initializer_list<std::size_t> faces) {
  PolygonMesh rest;
  rest.positions = mesh.positions;
  for (std::size_t f = 0; f < mesh.face_count(); ++f) {
    bool left_out = false;
    for (const std::size_t out : faces) left_out = left_out || out == f;
    if (!left_out) rest.AddFace(mesh.face(f));
  }
  return rest;
}

PolygonMesh Joined(const PolygonMesh& a, const PolygonMesh& b) {
  PolygonMesh both = a;
  const Index first = static_cast<Index>(a.vertex_count());
  for (const Vec3& p : b.positions) both.positions.push_back(p + Vec3{5, 0.5, 0.25});
  for (std::size_t f = 0; f < b.face_count(); ++f) {
    std::vector<Index> face;
    for (const Index v : b.face(f)) face.push_back(first + v);
    both.AddFace(face);
  }
  return both;
}

// Three quads around the inner corner of an L, which has three faces on the boundary.
PolygonMesh Ell() {
  return MakeMesh({{0, 0, 0},
                   {1, 0, 0.1},
                   {2, 0, 0},
                   {0, 1, 0.1},
                   {1, 1, 0.3},
                   {2, 1, 0.1},
                   {0, 2, 0},
                   {1, 2, 0.2}},
                  {{0, 1, 4, 3}, {1, 2, 5, 4}, {3, 4, 7, 6}});
}

// A pentagon, a quad and a triangle in a row.
PolygonMesh Strip() {
  return MakeMesh({{0, 0, 0},
                   {2, 0, 0.2},
                   {2, 1, 0.1},
                   {1, 2, 0},
                   {0, 1, 0.3},
                   {3, 0, 0},
                   {3, 1.5, 0.2},
                   {4, 0.5, 0.1}},
                  {{0, 1, 2, 3, 4}, {1, 5, 6, 2}, {5, 7, 6}});
}

using Maker = std::function<PolygonMesh()>;

std::vector<std::pair<std::string, Maker>> OpenMakers() {
  return {
      {"Triangle", [] { return SinglePolygon(3); }},
      {"Quad", [] { return SinglePolygon(4); }},
      {"Octagon", [] { return SinglePolygon(8); }},
      {"TwoQuads", [] { return QuadPatch(2, 1); }},
      {"QuadPatch4x3", [] { return QuadPatch(4, 3); }},
      {"QuadPatchJittered", [] { return Jittered(QuadPatch(5, 4), 3, 0.2); }},
      {"TriangleFan3", [] { return TriangleFan(3); }},
      {"TriangleFan7", [] { return TriangleFan(7); }},
      {"HalfFan2", [] { return HalfFan(2); }},
      {"HalfFan3", [] { return HalfFan(3); }},
      {"HalfFan6", [] { return HalfFan(6); }},
      {"Ell", Ell},
      {"Strip", Strip},
      {"Tube", [] { return OpenTube(5, 3); }},
      {"TubeOfOneRing", [] { return OpenTube(3, 1); }},
      {"CubeWithoutLid", [] { return Without(Cube(), {1}); }},
      {"DodecahedronWithTwoHoles",
       [] {
         return Without(Dodecahedron(), {0, 7});
       }},
      {"GenusThreeWithHoles",
       [] {
         return Without(GenusThree(), {2, 17, 30});
       }},
      {"TorusOfTrianglesWithHole",
       [] {
         return Without(TorusOfTriangles(5, 4), {0, 1, 2, 3, 9});
       }},
      {"OpenAndClosed", [] { return Joined(QuadPatch(2, 2), Jittered(Prism(5), 2, 0.1)); }},
      {"TwoPatches", [] { return Joined(HalfFan(4), SinglePolygon(5)); }},
      {"ShuffledPatch", [] { return Shuffled(QuadPatch(6, 5), 11); }},
  };
}

}  // namespace

PolygonMesh SinglePolygon(int n) {
  PolygonMesh mesh;
  std::vector<Index> face;
  for (int i = 0; i < n; ++i) {
    mesh.positions.push_back(OnCircle(i, n, 1, 0.1 * (i % 3)));
    face.push_back(static_cast<Index>(i));
  }
  mesh.AddFace(face);
  return mesh;
}

PolygonMesh QuadPatch(int width, int height) {
  PolygonMesh mesh;
  for (int y = 0; y <= height; ++y) {
    for (int x = 0; x <= width; ++x) {
      mesh.positions.push_back(
          {x + 0.1 * std::sin(3.0 * y), y + 0.1 * std::cos(2.0 * x), 0.5 * std::sin(x + 0.4 * y)});
    }
  }
  const int row = width + 1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int v = y * row + x;
      Add(&mesh, {v, v + 1, v + row + 1, v + row});
    }
  }
  return mesh;
}

PolygonMesh TriangleFan(int n) {
  PolygonMesh mesh;
  mesh.positions.push_back({0.1, 0, 0.5});
  for (int i = 0; i < n; ++i) mesh.positions.push_back(OnCircle(i, n, 1 + 0.1 * (i % 2), 0.1 * i));
  for (int i = 0; i < n; ++i) Add(&mesh, {0, 1 + i, 1 + (i + 1) % n});
  return mesh;
}

PolygonMesh HalfFan(int n) {
  PolygonMesh mesh;
  mesh.positions.push_back({0, 0, 0.2});
  for (int i = 0; i <= n; ++i) mesh.positions.push_back(OnCircle(i, 2 * n, 1, 0.1 * (i % 2)));
  for (int i = 0; i < n; ++i) Add(&mesh, {0, 1 + i, 2 + i});
  return mesh;
}

PolygonMesh OpenTube(int around, int along) {
  PolygonMesh mesh;
  for (int y = 0; y <= along; ++y) {
    for (int x = 0; x < around; ++x) {
      mesh.positions.push_back(OnCircle(x, around, 1 + 0.2 * std::sin(y), y + 0.1 * (x % 2)));
    }
  }
  for (int y = 0; y < along; ++y) {
    for (int x = 0; x < around; ++x) {
      const int next = (x + 1) % around;
      Add(&mesh,
          {y * around + x, y * around + next, (y + 1) * around + next, (y + 1) * around + x});
    }
  }
  return mesh;
}

std::vector<std::string> OpenMeshNames() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : OpenMakers()) names.push_back(name);
  return names;
}

PolygonMesh OpenMesh(const std::string& name) {
  for (const auto& [known, maker] : OpenMakers()) {
    if (known == name) return maker();
  }
  throw std::runtime_error("no open test mesh " + name);
}

}  // namespace limn::oracle
