// SPDX-License-Identifier: MIT
#include "tests/experiments/scene.h"

#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/io/mesh_writer.h"

namespace limn::experiments {
namespace {

// Above 1: the lights of the picture are dim.
constexpr char kMaterials[] =
    "newmtl body\nKd 0.5 0.72 0.95\nKs 0 0 0\n"
    "newmtl mark\nKd 0.1 0.85 0.1\nKs 0 0 0\n";

// Numbers of the next point and the next normal of an OBJ file; normal 0: the file has none.
struct Numbers {
  std::size_t point = 1;
  std::size_t normal = 0;
};

// A bar with a square section, both ends pointed.
void AppendBar(const Vec3& from, const Vec3& to, double radius, Numbers* next, std::string* text) {
  const Vec3 along = NormalizedOrZero(to - from);
  const Vec3 helper = std::fabs(along.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 a = NormalizedOrZero(Cross(along, helper));
  const Vec3 b = Cross(along, a);
  const std::array<Vec3, 10> out = {-1 * along, a, b, -1 * a, -1 * b, a, b, -1 * a, -1 * b, along};
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Vec3 p = (i < 5 ? from : to) + radius * out[i];
    absl::StrAppendFormat(text, "v %.9g %.9g %.9g\n", p.x, p.y, p.z);
    if (next->normal == 0) continue;
    absl::StrAppendFormat(text, "vn %.9g %.9g %.9g\n", out[i].x, out[i].y, out[i].z);
  }
  const auto face = [&](std::initializer_list<std::size_t> corners) {
    *text += "f";
    for (const std::size_t i : corners) {
      absl::StrAppend(text, " ", next->point + i);
      if (next->normal != 0) absl::StrAppend(text, "//", next->normal + i);
    }
    *text += "\n";
  };
  for (std::size_t i = 1; i <= 4; ++i) {
    const std::size_t j = i % 4 + 1;
    face({0, j, i});
    face({i, j, j + 4, i + 4});
    face({i + 4, j + 4, 9});
  }
  next->point += out.size();
  if (next->normal != 0) next->normal += out.size();
}

std::string MarksText(const std::vector<Mark>& marks, Numbers next) {
  constexpr double kRadius = 0.07;
  constexpr double kLength = 0.6;
  std::string text;
  for (const Mark& mark : marks) {
    const Vec3 up = {0, 0, 0.2 * kRadius};
    AppendBar(mark.point - up, mark.point + up, kRadius, &next, &text);
    if (mark.normal == Vec3{0, 0, 0}) continue;
    AppendBar(mark.point, mark.point + kLength * mark.normal, 0.6 * kRadius, &next, &text);
  }
  return text;
}

// Copies the mesh file NAME.obj into a scene.
void AddScene(const Setup& setup, const std::string& name, const std::string& marks) {
  std::ifstream file(setup.out + "/" + name + ".obj", std::ios::binary);
  const std::string mesh{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  // The viewer looks for materials under the name of the scene.
  WriteText(setup, "scenes/" + name + ".mtl", kMaterials);
  WriteText(setup, "scenes/" + name + ".obj",
            "mtllib " + name + ".mtl\nusemtl body\n" + mesh + "usemtl mark\n" + marks);
}

}  // namespace

void WriteScene(const Setup& setup, const std::string& name, const PolygonMesh& mesh,
                const std::vector<Mark>& marks) {
  OrDie(WriteMeshFile(setup.out + "/" + name + ".obj", mesh));
  AddScene(setup, name, MarksText(marks, {.point = mesh.vertex_count() + 1}));
}

void WriteScene(const Setup& setup, const std::string& name, const Tessellation& surface,
                const std::vector<Mark>& marks) {
  OrDie(WriteSurfaceFile(setup.out + "/" + name + ".obj", surface));
  const Numbers next = {.point = surface.vertex_count() + 1,
                        .normal = surface.normals.empty() ? 0 : surface.normals.size() + 1};
  AddScene(setup, name, MarksText(marks, next));
}

}  // namespace limn::experiments
